"""The plant's parameters: what each physical thing declares, and what ties several together."""

import math
from typing import ClassVar

from rodless_base.constants import NANOSECONDS_PER_SECOND
from rodless_base.parameters import Parameter, ParameterError, ParameterSet, collect
from rodless_sim import timing
from rodless_sim.instruments import instruments
from rodless_sim.node import command
from rodless_sim.physics import air, cylinder, forces, friction, valve, valve_assembly

# An explicit inner step follows a rate of change (1/s) faithfully while step x rate stays below
# this; a combination of values beyond it is refused instead of integrated badly.
MAXIMUM_STEP_TIMES_RATE = 0.7

DECLARATIONS = collect(
    air.PARAMETERS,
    valve_assembly.PARAMETERS,
    valve.PARAMETERS,
    command.PARAMETERS,
    cylinder.PARAMETERS,
    forces.PARAMETERS,
    friction.PARAMETERS,
    instruments.PARAMETERS,
    timing.PARAMETERS,
)


class RigParameters(ParameterSet):
    """The plant's parameters: always complete and valid as a whole; see docs/parameters.md.

    Parameters
    ----------
    values
        What differs from the defaults, by name. The defaults are the preset ``paper``.

    Raises
    ------
    ParameterError
        For a name, value or combination of values that no rig has; the text names it.

    Examples
    --------
    >>> from rodless_sim import RigParameters
    >>> calibrated = RigParameters.preset("calibrated")
    >>> calibrated.with_values({"supply.pressure": 0.6e6})
    RigParameters.preset('calibrated').with_values({'supply.pressure': 600000.0})
    >>> calibrated["friction.form"]
    'saturating'

    """

    DECLARATIONS: ClassVar[dict[str, Parameter]] = DECLARATIONS
    NODE: ClassVar[str] = "plant"

    def check_together(self) -> None:
        """Refuse combinations that no rig has, or that the inner step cannot follow."""
        sockets = (*valve_assembly.ASSEMBLIES, *friction.FORMS, *forces.FORCES)
        for thing in (air, valve, friction, cylinder, *sockets):
            if hasattr(thing, "check"):
                thing.check(self)
        self._check_period()
        self._check_step()

    def _check_period(self) -> None:
        period, step = self.number("time.period"), self.number("time.inner_step")
        if step > period:
            raise ParameterError(
                f"time.inner_step: {step:g} s refused, longer than time.period ({period:g} s)"
            )
        timeout = self.number("valve.command_timeout")
        if period > timeout:
            raise ParameterError(
                f"time.period: {period:g} s refused, longer than valve.command_timeout "
                f"({timeout:g} s): commands come once a period, the valve would close in between"
            )
        nanoseconds = period * NANOSECONDS_PER_SECOND
        if abs(nanoseconds - round(nanoseconds)) > 1e-6:
            raise ParameterError(
                f"time.period: {period!r} s refused, not a whole number of nanoseconds"
            )

    def _check_step(self) -> None:
        step = self.number("time.inner_step")
        for what, rate in self._rates().items():
            if rate * step > MAXIMUM_STEP_TIMES_RATE:
                raise ParameterError(
                    f"{what}: changes within {1e6 / rate:.3g} µs, too fast for time.inner_step "
                    f"{step:g} s; choose at most {MAXIMUM_STEP_TIMES_RATE / rate:.2g} s"
                )

    def _rates(self) -> dict[str, float]:
        """Fastest rates of change of the mechanics in 1/s, by the parameter to blame."""
        mass = self.number("cylinder.moving_mass")
        rates = {
            "end_stop.stiffness": math.sqrt(self.number("end_stop.stiffness") / mass),
            "end_stop.damping": self.number("end_stop.damping") / mass,
        }
        for side in ("forward", "reverse"):
            name = f"friction.{side}"
            drop = self.number(f"{name}.static") - self.number(f"{name}.coulomb")
            slope = math.sqrt(2.0 / math.e) * drop / self.number(f"{name}.stribeck_velocity")
            rates[f"{name}.viscous"] = self.number(f"{name}.viscous") / mass
            rates[f"{name}.stribeck_velocity"] = slope / mass
        return rates
