"""The rig: the plant at one instant, advanced by holding a voltage for a while."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from rodless_base.kernels import specialise
from rodless_sim.parameters import RigParameters
from rodless_sim.physics.motion import Motion, Plant, held
from rodless_sim.physics.plant import plant_constants
from rodless_sim.physics.ports import supply_flow
from rodless_sim.physics.settled import settled_pressures
from rodless_sim.physics.valve import MAXIMUM_VOLTAGE, MINIMUM_VOLTAGE, lands
from rodless_sim.timing import division
from rodless_sim.trace import Trace, run_open_loop, trace


class State(NamedTuple):
    """The rig at one instant: s, m, m/s, Pa absolute, V, N, kg/s.

    ``voltage`` is the command the valve holds; ``force`` is the pneumatic force A·(P_a − P_b);
    ``mass_flow_a`` and ``mass_flow_b`` enter the chambers.
    """

    time: float
    position: float
    velocity: float
    pressure_a: float
    pressure_b: float
    voltage: float
    force: float
    mass_flow_a: float
    mass_flow_b: float


def applied_voltage(voltage: float) -> float:
    """Return the command as the valve takes it, within 0-10 V; raises ValueError for NaN or Inf."""
    if not math.isfinite(voltage):
        raise ValueError(f"voltage {voltage!r} refused: not a finite number")
    return min(max(voltage, MINIMUM_VOLTAGE), MAXIMUM_VOLTAGE)


class Rig:
    """A rig at rest, its chambers settled at the closed valve, until it is advanced."""

    def __init__(self, parameters: RigParameters | None = None) -> None:
        """Build the rig of ``parameters`` (default: all defaults, the ``paper`` preset)."""
        self._parameters = parameters or RigParameters()
        self._plant = plant_constants(self._parameters)
        self._held = specialise(held, self._plant, 0.0, Motion(0.0, 0.0, 0.0, 0.0), 0, 0.0)
        self.reset()

    @property
    def parameters(self) -> RigParameters:
        """The parameters in force."""
        return self._parameters

    def configure(self, parameters: RigParameters) -> None:
        """Change the parameters; the carriage and the air in the chambers stay as they are."""
        self._parameters = parameters
        self._plant = plant_constants(parameters)
        self._hold(self._voltage, self._motion, 0, 0.0)

    def _hold(self, voltage: float, motion: Motion, steps: int, step: float) -> None:
        self._voltage = voltage
        self._motion, self._flow_a, self._flow_b = self._held(
            self._plant, voltage, motion, steps, step
        )

    def reset(
        self, position: float | None = None, pressures: tuple[float, float] | None = None
    ) -> State:
        """Put the carriage at rest at ``position`` (m; default ``cylinder.initial_position``).

        Time returns to zero, the valve closes, and the chambers hold ``pressures`` (Pa; default:
        those they settle at). Raises ValueError for a position outside the stroke.
        """
        if position is None:
            position = self._parameters.number("cylinder.initial_position")
        if not 0.0 <= position <= self._plant.cylinder.stroke:
            raise ValueError(f"position {position!r} m refused: outside the stroke")
        self._nanoseconds = 0
        closed = self._plant.valve.closed_voltage
        pressures = pressures or settled_pressures(self._plant, closed)
        self._hold(closed, Motion(position, 0.0, *pressures), 0, 0.0)
        return self.state

    def advance(self, voltage: float, duration: float) -> State:
        """Hold ``voltage`` (V) for ``duration`` (s, to the nanosecond) and return the state then.

        Raises ValueError for a voltage that is not finite or a duration that is not positive;
        the valve saturates at 0 and 10 V.
        """
        applied = applied_voltage(voltage)
        span, steps, step = division(duration, self._parameters.number("time.inner_step"))
        self._hold(applied, self._motion, steps, step)
        self._nanoseconds += span
        return self.state

    @property
    def nanoseconds(self) -> int:
        """Plant time as an integer count of nanoseconds."""
        return self._nanoseconds

    @property
    def plant(self) -> Plant:
        """The constants of the compiled equations."""
        return self._plant

    @property
    def motion(self) -> Motion:
        """Position, velocity and pressures as the compiled equations hold them."""
        return self._motion

    @property
    def free_air_flow(self) -> float:
        """Air drawn from the supply in m³/s at ambient pressure and temperature (ISO 8778)."""
        plant, motion = self._plant, self._motion
        edges = lands(plant.air, plant.valve, self._voltage)
        drawn = supply_flow(
            plant.air, edges, plant.supply_pressure, motion.pressure_a, motion.pressure_b
        )
        temperature = self._parameters.number("atmosphere.temperature")
        return drawn * plant.air.gas_constant * temperature / plant.ambient_pressure

    @property
    def state(self) -> State:
        """The rig now."""
        motion = self._motion
        return State(
            time=self._nanoseconds * 1e-9,
            position=motion.position,
            velocity=motion.velocity,
            pressure_a=motion.pressure_a,
            pressure_b=motion.pressure_b,
            voltage=self._voltage,
            force=self._plant.cylinder.piston_area * (motion.pressure_a - motion.pressure_b),
            mass_flow_a=self._flow_a,
            mass_flow_b=self._flow_b,
        )


def simulate(
    parameters: RigParameters,
    voltages: npt.ArrayLike,
    period: float,
    position: float | None = None,
    pressures: tuple[float, float] | None = None,
) -> Trace:
    """Drive a rig at rest with ``voltages`` (shape (n,), V), each held for ``period`` seconds.

    Returns n+1 samples, the first at the start. ``position`` (m) is where the carriage starts,
    ``pressures`` (Pa) are what the chambers start with; both as :meth:`Rig.reset` takes them.
    Raises ValueError as :meth:`Rig.advance` does.
    """
    rig = Rig(parameters)
    rig.reset(position, pressures)
    commands = np.array([applied_voltage(float(v)) for v in np.asarray(voltages).ravel()])
    if not commands.size:
        raise ValueError("no voltages given")
    span, steps, step = division(period, parameters.number("time.inner_step"))
    rows, _ = run_open_loop(rig.plant, commands, rig.motion, steps, step)
    return trace(rig.plant, span, np.append(commands, commands[-1]), rows)
