# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The plant's parameters: what each physical thing declares, and what ties several together."""

from collections.abc import Collection, Mapping
from typing import ClassVar

from rodless_base import frames
from rodless_base.constants import NANOSECONDS_PER_SECOND
from rodless_base.parameters import Parameter, ParameterError, ParameterSet, Value, collect
from rodless_sim import cylinder_series, faults, timing
from rodless_sim.instruments import acquisition, instruments
from rodless_sim.node import command
from rodless_sim.physics import (
    air,
    bristles,
    coupling,
    cylinder,
    drift,
    end_stop,
    flow_law,
    forces,
    friction,
    heat,
    leak,
    sagging_supply,
    spool,
    supply,
    tubes,
    valve,
    valve_assembly,
)

DECLARATIONS = collect(
    air.PARAMETERS,
    supply.PARAMETERS,
    sagging_supply.PARAMETERS,
    valve_assembly.PARAMETERS,
    valve.PARAMETERS,
    spool.PARAMETERS,
    tubes.PARAMETERS,
    flow_law.PARAMETERS,
    command.PARAMETERS,
    cylinder_series.PARAMETERS,
    cylinder.PARAMETERS,
    coupling.PARAMETERS,
    heat.PARAMETERS,
    leak.PARAMETERS,
    end_stop.PARAMETERS,
    forces.PARAMETERS,
    friction.PARAMETERS,
    bristles.PARAMETERS,
    drift.PARAMETERS,
    instruments.PARAMETERS,
    acquisition.PARAMETERS,
    faults.PARAMETERS,
    timing.PARAMETERS,
    frames.PARAMETERS,
)

REPLACED = {
    "time.inner_step": "time.tolerance bounds the error instead: leave this out",
    "end_stop.stiffness": "the end caps are rigid, end_stop.restitution says how it rebounds",
    "end_stop.damping": "the end caps are rigid, end_stop.restitution says how it rebounds",
}


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
    REPLACED: ClassVar[dict[str, str]] = REPLACED
    NODE: ClassVar[str] = "plant"

    @property
    def in_lockstep(self) -> bool:
        """Whether commands drive plant time, and not the wall clock."""
        return self.text("time.mode") == "lockstep"

    def derived(self, named: Collection[str], changed: Collection[str]) -> Mapping[str, Value]:
        """Return what follows for others than ``named`` from those of them that ``changed``."""
        return {**air.derived(self, named), **cylinder_series.derived(self, named, changed)}

    def check_together(self) -> None:
        """Refuse combinations that no rig has."""
        sockets = (
            *valve_assembly.ASSEMBLIES,
            *flow_law.LAWS,
            *friction.FORMS,
            *forces.FORCES,
        )
        things = (
            air,
            supply,
            sagging_supply,
            valve,
            friction,
            cylinder_series,
            cylinder,
            tubes,
            coupling,
            faults,
            frames,
        )
        for thing in (*things, *sockets):
            if hasattr(thing, "check"):
                thing.check(self)
        self._check_period()

    def _check_period(self) -> None:
        period = self.number("time.period")
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
