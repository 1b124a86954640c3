# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The rig near one steady motion, as a linear model."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from rodless_base.columns import Quantity, quantities
from rodless_base.constants import MAXIMUM_VOLTAGE, MINIMUM_VOLTAGE
from rodless_base.one_line import shown
from rodless_lab.simulation.linear_model import LinearModel, OperatingPoint
from rodless_lab.simulation.steady_motion import (
    NoSteadyMotionError,
    steady_motion,
    steady_pressures,
)
from rodless_sim.faults import ValveFault
from rodless_sim.parameters import RigParameters
from rodless_sim.physics.equations import rates
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings
from rodless_sim.physics.spool import Drive
from rodless_sim.physics.state import Motion
from rodless_sim.rig import applied_voltage, rig_parameters
from rodless_sim.single_number import single_number

Array = npt.NDArray[np.float64]

INPUTS = (
    Quantity("voltage", "V", "command to the valve"),
    Quantity("load", "N", "force on the carriage toward chamber B's end"),
    Quantity("supply_pressure", "Pa", "absolute supply pressure at the valve"),
)

# States of a spool that swings, behind those of the motion.
SPOOL_STATES = (
    Quantity("spool_voltage", "V", "where the valve's spool is: the command that would hold it"),
    Quantity("spool_speed", "V/s", "rate of change of spool_voltage"),
)

# Of a difference, by unit: the curves are straight over these to some parts in 10⁸, and the rates
# are known to some parts in 10¹⁵. Friction alone bends more: its step is a thousandth of the least
# Stribeck velocity.
STEPS = {"m": 1e-6, "m/s": 1e-7, "Pa": 1.0, "V": 1e-5}

# Weights of f(h) - f(0) to f(4 h) - f(0) in h f'(0): the one-sided difference of fourth order
# (Fornberg, Mathematics of Computation 51 (1988), 699-706).
ONE_SIDED = (4.0, -3.0, 4.0 / 3.0, -1.0 / 4.0)


def linearise(
    parameters: RigParameters, position: float, voltage: float, velocity: float | None = None
) -> LinearModel:
    """Return the linear model of the rig about a steady motion.

    The carriage passes ``position`` at the velocity that ``voltage`` gives it, the pressures
    constant. The derivatives are differences of the equations of motion (eqs. (26) to (31)), that
    with the velocity in the direction of motion. At rest the rig is not linear, for friction: see
    ``velocity``.

    Faults of valve, air and carriage are in the model as in the rig, or refused. Its outputs are
    the true states: faults and errors of the sensors are not in it.

    Parameters
    ----------
    parameters
        Those of the rig.
    position
        Where the carriage passes, m, within the stroke.
    voltage
        Command to the valve, V, from 0 to 10. At these limits, beyond which the valve saturates,
        the model is that of voltages within; in the closed position the voltage's effect is the
        mean of both sides. With ``fault.valve.offset`` the valve has that much more, and the
        limits are those of the sum.
    velocity
        In m/s; by default that which the voltage gives the carriage. At another one, a constant
        load keeps the balance: ``model.point.load``. At 0 friction is taken as for a carriage
        that begins to slide forward.

    Returns
    -------
    LinearModel
        Its states are those of the rig, and all of them its outputs; its inputs are the voltage,
        a load on the carriage, and the supply pressure. With ``valve.dynamics`` ``second_order``
        the spool has two states more.

    Raises
    ------
    ValueError
        For a position outside the stroke, values that are not finite, a voltage at which the
        carriage sticks, a carriage that is locked or seized, chambers with temperatures of their
        own, friction that drifts, or a valve that is stuck, or has hysteresis or dead time.
    TypeError
        For what are no :class:`RigParameters`.

    Examples
    --------
    >>> from rodless_lab import linearise
    >>> from rodless_sim import RigParameters
    >>> model = linearise(RigParameters(), position=0.1, voltage=6.0)
    >>> f"{model.point.motion.velocity * 1e3:.1f} mm/s"
    '23.7 mm/s'

    """
    plant = Plant.of(rig_parameters(parameters))
    if plant.heated:
        raise ValueError(
            "chambers.thermodynamics energy_balance refused: linear models of chambers with "
            "temperatures are not built; adiabatic and polytropic have one"
        )
    for name, without in WITHOUT.items():
        if parameters.text(name) != without:
            raise ValueError(
                f"{name} {parameters.text(name)} refused: linear models have no bristles, magnets "
                f"that lag, tubes, compressor or stuck spool; set it to {without}"
            )
    for name in NOTHING:
        if parameters.number(name):
            raise ValueError(
                f"{name}: {parameters.number(name):g} refused, a linear model has no play, delay, "
                "unsteady supply or drift; set it to 0"
            )
    if plant.cylinder.locked:
        held = SEIZED if parameters[SEIZED] else "cylinder.locked"
        raise ValueError(
            f"{held} is set: a carriage that is held has no linear model; set it to false"
        )
    command = _command(voltage)
    at_valve = _at_valve(parameters, command)
    point = _operating_point(plant, position, command, at_valve, velocity)
    by_state, by_input, states = (
        _by_state(plant, point, at_valve),
        _by_input(plant, point, at_valve),
        quantities(Motion),
    )
    if plant.drive:
        by_state, by_input = _behind_the_spool(plant.drive, by_state, by_input)
        states += SPOOL_STATES
    return LinearModel(
        A=by_state,
        B=by_input,
        C=np.eye(len(states)),
        D=np.zeros((len(states), len(INPUTS))),
        states=states,
        inputs=INPUTS,
        outputs=states,
        point=point,
    )


# Options without which a rig has the states of a linear model.
WITHOUT = {
    "friction.dynamics": "static",
    "coupling.kind": "rigid",
    "tubes.model": "none",
    "supply.kind": "regulated",
    "fault.valve.spool": "free",
}
NOTHING = (
    "valve.hysteresis",
    "valve.dead_time",
    "supply.ripple_amplitude",
    "supply.droop",
    "friction.drift",
)

OFFSET = "fault.valve.offset"
SEIZED = "fault.carriage.seized"


def _behind_the_spool(drive: Drive, by_state: Array, by_input: Array) -> tuple[Array, Array]:
    """Return A and B where the voltage moves the spool, and the spool's place acts as it did."""
    motions, inputs = by_input.shape
    frequency = drive.natural_frequency
    oscillator = np.array([[0.0, 1.0], [-(frequency**2), -2.0 * drive.damping * frequency]])
    place = np.column_stack([by_input[:, 0], np.zeros(motions)])
    direct = by_input.copy()
    direct[:, 0] = 0.0
    driven = np.zeros((2, inputs))
    driven[1, 0] = frequency**2
    return (
        np.block([[by_state, place], [np.zeros((2, motions)), oscillator]]),
        np.vstack([direct, driven]),
    )


def _command(voltage: float) -> float:
    """Return the command in V; raises ValueError where the valve saturates."""
    applied = applied_voltage(voltage)
    if applied != single_number(voltage, "voltage", "volts"):
        raise ValueError(
            f"voltage {shown(voltage)} V refused: beyond 0 to 10 V the valve saturates"
        )
    return applied


def _at_valve(parameters: RigParameters, command: float) -> float:
    """Return the voltage (V) that the valve follows; raises ValueError where it saturates."""
    offset = parameters.number(OFFSET)
    followed = ValveFault.of(parameters).voltage(command, command)
    if abs(followed - (command + offset)) > STEPS["V"]:
        least, most = MINIMUM_VOLTAGE - offset, MAXIMUM_VOLTAGE - offset
        raise ValueError(
            f"voltage {command:g} V refused: with {OFFSET} it is {command + offset:g} V, and "
            f"beyond 0 to 10 V the valve saturates; give one from {max(least, MINIMUM_VOLTAGE):g} "
            f"to {min(most, MAXIMUM_VOLTAGE):g} V"
        )
    return followed


def _operating_point(
    plant: Plant, position: float, command: float, at_valve: float, velocity: float | None
) -> OperatingPoint:
    """Return the steady motion at ``position`` (m) where ``command`` gives the valve ``at_valve``.

    Both in V.
    """
    where = single_number(position, "position", "metres")
    if not 0.0 < where < plant.cylinder.stroke:
        raise ValueError(
            f"position {where:g} m refused: must be within the stroke, above 0 and below "
            f"{plant.cylinder.stroke:g} m"
        )
    try:
        if velocity is None:
            return OperatingPoint(steady_motion(plant, where, at_valve), command, 0.0)
        speed = single_number(velocity, "velocity", "m/s")
        if not np.isfinite(speed):
            raise ValueError(f"velocity {shown(velocity)} refused: not a finite number")
        motion = steady_pressures(plant, where, at_valve, speed, _direction(speed))
    except NoSteadyMotionError as error:
        if at_valve == command:
            raise
        raise NoSteadyMotionError(
            f"{error}; {at_valve:g} V is what {OFFSET} makes of {command:g} V"
        ) from error
    found = rates(plant, openings(plant, at_valve), motion, _direction(speed))
    return OperatingPoint(motion, command, -plant.cylinder.moving_mass * found.velocity)


def _direction(velocity: float) -> int:
    return -1 if velocity < 0.0 else 1


def _central(of: Callable[[float], Array], step: float) -> Array:
    """Return the derivative at 0, from both sides."""
    return np.asarray((of(step) - of(-step)) / (2.0 * step))


def _one_sided(of: Callable[[float], Array], step: float) -> Array:
    """Return the derivative at 0, from the side that ``step`` leads to."""
    here = of(0.0)
    more = [of((place + 1) * step) - here for place in range(len(ONE_SIDED))]
    return np.asarray(ONE_SIDED @ np.array(more) / step)


def _by_state(plant: Plant, point: OperatingPoint, at_valve: float) -> Array:
    """Return the derivatives of all rates with respect to each state, shape (n, n)."""
    lands = openings(plant, at_valve)
    direction = _direction(point.motion.velocity)

    def by(name: str, unit: str) -> Array:
        def rate(change: float) -> Array:
            state = point.motion._replace(**{name: getattr(point.motion, name) + change})
            return np.array(rates(plant, lands, state, direction))

        # Friction of the other direction is another: a carriage about to slide is this side of it.
        if name == "velocity":
            return _one_sided(rate, direction * STEPS[unit])
        return _central(rate, STEPS[unit])

    return np.column_stack([by(name, unit) for name, unit, _ in quantities(Motion)])


def _by_input(plant: Plant, point: OperatingPoint, at_valve: float) -> Array:
    """Return the derivatives of all rates with respect to each of INPUTS, shape (n, 3)."""
    direction = _direction(point.motion.velocity)

    def at_voltage(change: float) -> Array:
        lands = openings(plant, at_valve + change)
        return np.array(rates(plant, lands, point.motion, direction))

    def at_supply(change: float) -> Array:
        changed = plant._replace(supply_pressure=plant.supply_pressure + change)
        lands = openings(changed, at_valve)
        return np.array(rates(changed, lands, point.motion, direction))

    load = np.zeros(len(Motion._fields))
    load[Motion._fields.index("velocity")] = 1.0 / plant.cylinder.moving_mass
    return np.column_stack(
        [_by_voltage(at_voltage, at_valve), load, _central(at_supply, STEPS["Pa"])]
    )


def _by_voltage(of: Callable[[float], Array], at_valve: float) -> Array:
    """Return the derivative with the voltage: at the valve's limits from within."""
    step = STEPS["V"]
    if at_valve + step > MAXIMUM_VOLTAGE:
        return _one_sided(of, -step)
    if at_valve - step < MINIMUM_VOLTAGE:
        return _one_sided(of, step)
    return _central(of, step)
