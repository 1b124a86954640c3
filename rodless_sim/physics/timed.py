# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Equations that change with plant time: a supply that ripples, air under way in tubes.

A course of its own then takes the place of the valve's, which it holds. The stages of
:mod:`integrator` take the equations at their own instants, as in :mod:`course`; the rates' change
with time is a difference over a small part of the step.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from rodless_base.kernels import kernel, kernel_by_type, outlined_kernel, version_for
from rodless_sim.physics import course as valve_course
from rodless_sim.physics import equations, full_rates, full_step
from rodless_sim.physics.air_in_tubes import (
    COLUMNS,
    FIRST_ROWS,
    LARGEST_SHARE,
    MOST_PARTS,
    SDIRK,
    TIME,
    A,
    B,
    End,
    Tubes,
    Window,
    filled,
    hermite,
    next_jump,
    noted,
    opened,
    parts_of,
    row_at,
    share_of,
    stiffness,
)
from rodless_sim.physics.course import (
    ALPHA,
    in_time_error,
    moving,
    openings_after,
    staged_with,
    worse,
)
from rodless_sim.physics.cylinder import volume_a, volume_b
from rodless_sim.physics.equations import Inflows, less_leaks, motion_rate, rates
from rodless_sim.physics.full_rates import air_rates, supply_at_valve
from rodless_sim.physics.heat import NetInflow, enthalpy_capacity
from rodless_sim.physics.heated import NetInflows
from rodless_sim.physics.heated import less_leaks as less_heated_leaks
from rodless_sim.physics.integrator import (
    Matrix,
    staged,
)
from rodless_sim.physics.lands import AnyCourse, Arriving, Lands, Timed
from rodless_sim.physics.plant import Plant, supplied
from rodless_sim.physics.ports import Inflow, supply_flow
from rodless_sim.physics.spool import AnySpool, Drive, Memory, starting_spool
from rodless_sim.physics.state import AnyMotion, FullMotion, HeatedMotion, Motion, moved
from rodless_sim.physics.supply import longest_step, rippled

# Of a step: for the rates' change with time.
SMALL = 1e-3


@kernel
def now_supplied(plant: Plant, time: float) -> Plant:
    """Return the plant with its supply's pressure at ``time`` (s)."""
    return supplied(plant, rippled(plant.ripple, plant.supply_pressure, time))


@kernel_by_type
def fed_by(
    plant: Plant,
    after: AnyMotion,  # noqa: ARG001
    supply: float,  # noqa: ARG001
    time: float,
    share: float,  # noqa: ARG001
) -> Plant:
    """Return the plant with the supply as it is at the valve at ``time`` (s).

    A supply that is a state goes straight from ``supply`` (Pa) to what it is ``after`` a step.
    """
    return now_supplied(plant, time)


@version_for(FullMotion, fed_by)
def _fed_by(plant: Plant, after: FullMotion, supply: float, time: float, share: float) -> Plant:
    now = now_supplied(plant, time)
    if not plant.full.supply.acting:
        return now
    return supplied(plant, supply + share * (supply_at_valve(now, after) - supply))


# What is different with tubes, and without any.


@kernel_by_type
def tubes_opened(
    plant: Plant,  # noqa: ARG001
    tubes: tuple[()],
    supply: float,  # noqa: ARG001
    lands: Lands,  # noqa: ARG001
) -> tuple[()]:
    """Return the tubes once the valve's openings are ``lands``, with the ``supply`` (Pa) there."""
    return tubes


@version_for(Tubes, tubes_opened)
def _tubes_opened(plant: Plant, tubes: Tubes, supply: float, lands: Lands) -> Tubes:
    now = supplied(plant, supply)
    a, b = opened(now, lands, False, tubes.a), opened(now, lands, True, tubes.b)
    row = tubes.history[tubes.rows - 1]
    row[A + 2], row[B + 2] = a.flow, b.flow
    return Tubes(tubes.history, tubes.rows, tubes.last, a, b)


@kernel_by_type
def horizon(plant: Plant, tubes: tuple[()], time: float) -> float:  # noqa: ARG001
    """Return the longest step in s from ``time`` that the air in the tubes allows."""
    return math.inf


@version_for(Tubes, horizon)
def _horizon(plant: Plant, tubes: Tubes, time: float) -> float:
    delay: float = plant.tubes.delay
    return min(delay, next_jump(tubes, time - delay) + delay - time)


class Windows(NamedTuple):
    """What arrives at each chamber during a step."""

    a: Window
    b: Window


@kernel_by_type
def windows(
    plant: Plant,  # noqa: ARG001
    tubes: tuple[()],
    time: float,  # noqa: ARG001
    step: float,  # noqa: ARG001
) -> tuple[()]:
    """Return what arrives at the chambers within ``step`` s from ``time``; nothing of no tubes."""
    return tubes


@version_for(Tubes, windows)
def _windows(plant: Plant, tubes: Tubes, time: float, step: float) -> Windows:
    since = time - plant.tubes.delay
    until = since + step
    row = row_at(tubes, until, True)
    start_a, begin_a = hermite(tubes.history, tubes.last, A, since)
    start_b, begin_b = hermite(tubes.history, tubes.last, B, since)
    end_a, last_a = hermite(tubes.history, row, A, until)
    end_b, last_b = hermite(tubes.history, row, B, until)
    return Windows(
        Window(begin_a, last_a, (end_a - start_a) / step),
        Window(begin_b, last_b, (end_b - start_b) / step),
    )


@kernel_by_type
def within(
    plant: Plant,
    arriving: tuple[()],  # noqa: ARG001
    valve: AnyCourse,
    step: float,
    share: float,
) -> Any:
    """Return what lets air into the chambers at a share of a step: the valve's openings."""
    return openings_after(plant, valve, share * step)


@version_for(Windows, within)
def _within(
    plant: Plant,  # noqa: ARG001
    arriving: Windows,
    valve: AnyCourse,  # noqa: ARG001
    step: float,  # noqa: ARG001
    share: float,
) -> Arriving:
    return Arriving(share_of(arriving.a, share), share_of(arriving.b, share))


@kernel_by_type
def let_in(
    plant: Plant,
    tubes: tuple[()],  # noqa: ARG001
    valve: AnyCourse,
    time: float,  # noqa: ARG001
) -> Any:
    """Return what lets air into the chambers at ``time``."""
    return openings_after(plant, valve, 0.0)


@version_for(Tubes, let_in)
def _let_in(
    plant: Plant,
    tubes: Tubes,
    valve: AnyCourse,  # noqa: ARG001
    time: float,
) -> Arriving:
    since = time - plant.tubes.delay
    _, a = hermite(tubes.history, tubes.last, A, since)
    _, b = hermite(tubes.history, tubes.last, B, since)
    return Arriving(a, b)


@kernel_by_type
def arrived(plant: Plant, state: Motion, a: float, b: float) -> Inflows:
    """Return what flows into both chambers where ``a`` and ``b`` (kg/s) come out of the tubes."""
    flows = Inflows(Inflow(a, 0.0, 0.0), Inflow(b, 0.0, 0.0))
    if plant.leak.open:
        return less_leaks(plant, state, flows)
    return flows


@version_for((HeatedMotion, FullMotion), arrived)
def warm_arrived(plant: Plant, state: HeatedMotion | FullMotion, a: float, b: float) -> NetInflows:
    """:func:`arrived` at chambers that have temperatures."""
    flows = NetInflows(
        warm_inflow(plant, a, state.temperature_a), warm_inflow(plant, b, state.temperature_b)
    )
    if plant.leak.open:
        return less_heated_leaks(plant, state, flows)
    return flows


@kernel
def warm_inflow(plant: Plant, flow: float, temperature: float) -> NetInflow:
    """Return a ``flow`` (kg/s) out of a tube, whose air has the supply's temperature."""
    capacity = enthalpy_capacity(plant.air)
    upstream = plant.air.temperature if flow >= 0.0 else temperature
    by_temperature = 0.0 if flow >= 0.0 else capacity * flow
    return NetInflow(
        flow, 0.0, 0.0, 0.0, 0.0, capacity * upstream * flow, 0.0, by_temperature, 0.0, 0.0
    )


@version_for(Arriving, equations.inflows)
def _arriving_inflows(plant: Plant, course: Arriving, state: AnyMotion) -> object:
    return arrived(plant, state, course.a, course.b)


@kernel_by_type
def tubes_after(
    plant: Plant,  # noqa: ARG001
    tubes: tuple[()],
    course: Timed,  # noqa: ARG001
    step: float,  # noqa: ARG001
    after: AnyMotion,  # noqa: ARG001
) -> tuple[()]:
    """Return the tubes after a step along ``course`` to the state ``after``."""
    return tubes


@version_for(Tubes, tubes_after)
def _tubes_after(plant: Plant, tubes: Tubes, course: Timed, step: float, after: AnyMotion) -> Tubes:
    return fed(plant, tubes, course, step, after)


@outlined_kernel
def fed(plant: Plant, tubes: Tubes, course: Timed, step: float, after: AnyMotion) -> Tubes:
    """Let the valve feed the tubes for ``step`` s, in parts."""
    time, valve, start_a, start_b = course.time, course.valve, tubes.a, tubes.b
    level_a, stiff_a, level_b, stiff_b = levels(plant, tubes, time + step, after)
    wanted = max(parts_of(start_a, step), parts_of(start_b, step))
    wanted = max(wanted, step / (LARGEST_SHARE * plant.tubes.delay), step / valve_time(plant))
    parts = int(min(wanted, MOST_PARTS - 1)) + 1
    length = step / parts
    for part in range(parts):
        early, late = (part + SDIRK) / parts, (part + 1) / parts
        now = fed_by(plant, after, course.supply, time + early * step, early)
        then = fed_by(plant, after, course.supply, time + late * step, late)
        middle, last = (
            openings_after(plant, valve, early * step),
            openings_after(plant, valve, late * step),
        )
        level = start_a.level + late * (level_a - start_a.level)
        stiff = start_a.stiffness + late * (stiff_a - start_a.stiffness)
        a = filled(now, then, middle, last, False, tubes.a, level, stiff, length)
        level = start_b.level + late * (level_b - start_b.level)
        stiff = start_b.stiffness + late * (stiff_b - start_b.stiffness)
        b = filled(now, then, middle, last, True, tubes.b, level, stiff, length)
        tubes = noted(tubes, time + step if part + 1 == parts else time + late * step, a, b)
    since = time + step - plant.tubes.delay
    return Tubes(tubes.history, tubes.rows, row_at(tubes, since, False), tubes.a, tubes.b)


@kernel_by_type
def piston_of(plant: Plant, state: AnyMotion) -> tuple[float, float]:  # noqa: ARG001
    """Return position (m) and velocity (m/s) of the piston."""
    return state.position, state.velocity


@version_for(FullMotion, piston_of)
def _piston_of(plant: Plant, state: FullMotion) -> tuple[float, float]:
    if plant.full.coupling.magnetic:
        return state.piston_position, state.piston_velocity
    return state.position, state.velocity


@kernel_by_type
def pressures_change(plant: Plant, state: AnyMotion, a: float, b: float) -> tuple[float, float]:
    """Return dP/dt (Pa/s) of both chambers where ``a`` and ``b`` (kg/s) come out of the tubes."""
    flows = arrived(plant, state, a, b)
    first, second = equations.pressure_rates(plant, state, flows, state.velocity)
    rate = motion_rate(0.0, 0.0, first, second)
    return rate.pressure_a, rate.pressure_b


@version_for(FullMotion, pressures_change)
def _pressures_change(plant: Plant, state: FullMotion, a: float, b: float) -> tuple[float, float]:
    position, velocity = piston_of(plant, state)
    flows = warm_arrived(plant, state, a, b)
    rates_of_air = air_rates(plant, flows, state, position, velocity)
    return rates_of_air[0], rates_of_air[1]


@kernel
def levels(
    plant: Plant, tubes: Tubes, time: float, state: AnyMotion
) -> tuple[float, float, float, float]:
    """Return D (Pa) and K (Pa/kg) of A, then of B, with the rig in ``state`` at ``time``."""
    delay = plant.tubes.delay
    row = row_at(tubes, time - delay, False)
    mass_a, a = hermite(tubes.history, row, A, time - delay)
    mass_b, b = hermite(tubes.history, row, B, time - delay)
    rate_a, rate_b = pressures_change(plant, state, a, b)
    position, _ = piston_of(plant, state)
    stiff_a = stiffness(plant.air, volume_a(plant.cylinder, position))
    stiff_b = stiffness(plant.air, volume_b(plant.cylinder, position))
    return (
        state.pressure_a + delay * (rate_a - stiff_a * a) - stiff_a * mass_a,
        stiff_a,
        state.pressure_b + delay * (rate_b - stiff_b * b) - stiff_b * mass_b,
        stiff_b,
    )


@kernel
def valve_time(plant: Plant) -> float:
    """Return the longest part in s that sees how valve and supply move."""
    return min(spool_time(plant.drive), 0.25 * longest_step(plant.ripple))


@kernel_by_type
def spool_time(drive: tuple[()]) -> float:  # noqa: ARG001
    """Return a quarter of the time in s that the spool takes for a radian."""
    return math.inf


@version_for(Drive, spool_time)
def _spool_time(drive: Drive) -> float:
    return 0.25 / drive.natural_frequency if drive.natural_frequency > 0.0 else math.inf


# The course.


@version_for(Memory, valve_course.course_at)
def _course_at(plant: Plant, memory: Memory, voltage: float) -> Timed:
    valve = valve_course.course_at(plant, memory.spool, voltage)
    tubes = tubes_opened(plant, memory.tubes, memory.supply, openings_after(plant, valve, 0.0))
    return Timed(memory.time, memory.supply, valve, tubes)


@version_for(Timed, valve_course.spool_of)
def _spool_of(course: Timed) -> Memory:
    return Memory(valve_course.spool_of(course.valve), course.time, course.supply, course.tubes)


@version_for(Timed, valve_course.step_on)
def _step_on(plant: Plant, course: Timed, step: float) -> float:
    step = min(step, longest_step(plant.ripple), horizon(plant, course.tubes, course.time))
    return valve_course.step_on(plant, course.valve, step)


@version_for(Timed, valve_course.course_after)
def _course_after(plant: Plant, course: Timed, elapsed: float, after: AnyMotion) -> Timed:
    tubes = tubes_after(plant, course.tubes, course, elapsed, after)
    valve = valve_course.course_after(plant, course.valve, elapsed, after)
    time = course.time + elapsed
    return Timed(time, supply_at_valve(now_supplied(plant, time), after), valve, tubes)


@version_for(Timed, equations.inflows)
def _inflows(plant: Plant, course: Timed, state: AnyMotion) -> object:
    now = now_supplied(plant, course.time)
    return equations.inflows(now, let_in(plant, course.tubes, course.valve, course.time), state)


@version_for(Timed, staged)
def _staged(
    plant: Plant,
    course: Timed,
    state: AnyMotion,
    direction: int,
    matrix: Matrix,
    first: AnyMotion,
    step: float,
) -> tuple[AnyMotion, float]:
    return staged_in_time(plant, course, state, direction, matrix, first, step)


@outlined_kernel
def staged_in_time(
    plant: Plant,
    course: Timed,
    state: AnyMotion,
    direction: int,
    matrix: Matrix,
    first: AnyMotion,
    step: float,
) -> tuple[AnyMotion, float]:
    """Take one step as :func:`staged` does, the equations changing with time."""
    arriving = windows(plant, course.tubes, course.time, step)
    soon = now_supplied(plant, course.time + SMALL * step)
    then = now_supplied(plant, course.time + ALPHA * step)
    near = within(plant, arriving, course.valve, step, SMALL)
    ahead = within(plant, arriving, course.valve, step, ALPHA)
    change, weight = moved(rates(soon, near, state, direction), first, -1.0), 1.0 / SMALL
    after, size = staged_with(then, ahead, state, direction, matrix, first, change, weight, step)
    if moving(course):
        middle = rates(then, ahead, state, direction)
        end = within(plant, arriving, course.valve, step, 1.0)
        last = rates(now_supplied(plant, course.time + step), end, state, direction)
        size = worse(size, in_time_error(first, change, weight, middle, last, step))
    return after, size


@version_for(Timed, moving)
def _moving(course: Timed) -> bool:
    # Tubes are fed in parts of their own.
    return course.tubes == () and moving(course.valve)


# For full_step.


class Instant(NamedTuple):
    """What lets air into the chambers at one instant, and the supply then."""

    supply: float  # Pa, plant.supply_pressure then
    inlet: Any  # Lands or Arriving
    drawn: float  # kg/s from the supply, where there are tubes


class Spanned(NamedTuple):
    """A course for one step of known length."""

    course: Timed
    step: float  # s
    arriving: Any  # Windows, () without tubes
    drawn: float  # kg/s


@version_for(Timed, full_step.spanned)
def _spanned(plant: Plant, course: Timed, step: float) -> Spanned:
    arriving = windows(plant, course.tubes, course.time, step)
    return Spanned(course, step, arriving, drawn_by(plant, course.tubes, course))


@version_for(Spanned, openings_after)
def _openings_after(plant: Plant, course: Spanned, elapsed: float) -> Instant:
    supply = rippled(plant.ripple, plant.supply_pressure, course.course.time + elapsed)
    inlet = within(plant, course.arriving, course.course.valve, course.step, elapsed / course.step)
    return Instant(supply, inlet, course.drawn)


@version_for(Spanned, moving)
def _spanned_moving(course: Spanned) -> bool:
    return moving(course.course)


@version_for(Spanned, full_step.openings_beside)
def _openings_beside(plant: Plant, course: Spanned) -> tuple[object, float]:
    near = SMALL * course.step
    return openings_after(plant, course, near), 1.0 / near


@version_for(Instant, full_rates.as_supplied)
def _as_supplied(plant: Plant, lands: Instant) -> Plant:
    return supplied(plant, lands.supply)


@version_for(Instant, equations.inflows)
def _instant_inflows(plant: Plant, course: Instant, state: AnyMotion) -> object:
    return equations.inflows(plant, course.inlet, state)


@version_for(Instant, full_rates.drawn_flow)
def _drawn_flow(plant: Plant, lands: Instant, state: FullMotion) -> float:
    return drawn_through(plant, lands.inlet, state, lands.drawn)


@kernel_by_type
def drawn_through(plant: Plant, inlet: Any, state: FullMotion, drawn: float) -> float:  # noqa: ARG001
    """Return what the supply gives (kg/s): what passes the valve, which tubes know already."""
    return full_rates.drawn_flow(plant, inlet, state)


@version_for(Arriving, drawn_through)
def _drawn_through(plant: Plant, inlet: Arriving, state: FullMotion, drawn: float) -> float:  # noqa: ARG001
    return drawn


@kernel_by_type
def drawn_by(plant: Plant, tubes: tuple[()], course: Timed) -> float:  # noqa: ARG001
    """Return what the tubes' ends draw from the supply at the start of a step, kg/s."""
    return 0.0


@version_for(Tubes, drawn_by)
def _drawn_by(plant: Plant, tubes: Tubes, course: Timed) -> float:
    lands = openings_after(plant, course.valve, 0.0)
    now = supplied(plant, course.supply)
    return supply_flow(now, lands, tubes.a.pressure, tubes.b.pressure)


# What valve and tubes remember, at the start.


def memory_of(plant: Plant, motion: AnyMotion, voltage: float, time: float = 0.0) -> AnySpool:
    """Return what valve and tubes remember of a rig at rest in ``motion`` at ``time`` (s).

    The spool rests where ``voltage`` (V) holds it. Air has always been on its way to where it leaks
    out of the chambers.
    """
    spool = starting_spool(plant.drive, voltage)
    if plant.ripple == ():
        return spool
    supply = float(supply_at_valve(now_supplied(plant, time), motion))
    return Memory(spool, time, supply, resting_tubes(plant, motion, time) if plant.tubes else ())


def memory_like(plant: Plant) -> AnySpool:
    """Return a memory of the types of :func:`memory_of`; what is in it means nothing.

    That calls compiled functions, which a new kind of plant does not have yet.
    """
    spool = starting_spool(plant.drive, 0.0)
    if plant.ripple == ():
        return spool
    end = End(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    tubes = Tubes(np.zeros((FIRST_ROWS, COLUMNS)), 2, 0, end, end) if plant.tubes else ()
    return Memory(spool, 0.0, 0.0, tubes)


def resting_tubes(plant: Plant, motion: AnyMotion, time: float) -> Tubes:
    """Return tubes through which what leaks out of the chambers in ``motion`` flows."""
    out = arrived(plant, motion, 0.0, 0.0)
    flows = -float(out.a.mass_flow), -float(out.b.mass_flow)
    history = np.zeros((FIRST_ROWS, COLUMNS))
    delay = plant.tubes.delay
    ends = []
    for column, flow, pressure, volume in zip(
        (A, B),
        flows,
        (motion.pressure_a, motion.pressure_b),
        (volume_a(plant.cylinder, motion.position), volume_b(plant.cylinder, motion.position)),
        strict=True,
    ):
        # One delay before the start, and the start.
        history[:2, column] = -flow * delay, 0.0
        history[:2, column + 1 : column + 3] = flow
        stiff = stiffness(plant.air, volume)
        ends.append(End(0.0, flow, float(pressure), stiff, float(pressure), 0.0))
    history[:2, TIME] = time - delay, time
    return Tubes(history, 2, 0, *ends)


def tubes_in(memory: AnySpool) -> Tubes | tuple[()]:
    """Return the tubes that are remembered; nothing of a rig without them."""
    return memory.tubes if isinstance(memory, Memory) else ()


def with_tubes(memory: AnySpool, tubes: Tubes | tuple[()]) -> AnySpool:
    """Return ``memory`` with the air that is on its way in ``tubes``, if both have such."""
    if isinstance(memory, Memory) and memory.tubes and tubes:
        return memory._replace(tubes=tubes)
    return memory


def at_speed_of(plant: Plant, before: Plant, memory: AnySpool) -> AnySpool:
    """Return ``memory`` of the plant ``before``, its air going on with the delay of ``plant``.

    None is lost: what has half of its way behind it has half of the new delay ahead.
    """
    if not isinstance(memory, Memory) or not isinstance(memory.tubes, Tubes):
        return memory
    tubes, ratio = memory.tubes, plant.tubes.delay / before.tubes.delay
    history = tubes.history.copy()
    used = history[: tubes.rows]
    used[:, TIME] = memory.time - ratio * (memory.time - used[:, TIME])
    for column in (A, B):
        used[:, column + 1 : column + 3] /= ratio
    return memory._replace(tubes=tubes._replace(history=history))


def supplied_anew(plant: Plant, before: Plant, memory: AnySpool, motion: AnyMotion) -> AnySpool:
    """Return ``memory`` of the plant ``before``, the valve fed as ``plant`` has it from now on."""
    if not isinstance(memory, Memory) or feed_of(plant) == feed_of(before):
        return memory
    supply = float(supply_at_valve(now_supplied(plant, memory.time), motion))
    return memory._replace(supply=supply)


def feed_of(plant: Plant) -> tuple[object, ...]:
    """Return all that decides the supply's pressure at the valve, but for states."""
    return plant.supply_pressure, plant.ripple, plant.full and plant.full.supply


def copied(memory: AnySpool) -> AnySpool:
    """Return the same memory with a history of its own: that of a run is written where it is."""
    if not isinstance(memory, Memory) or not isinstance(memory.tubes, Tubes):
        return memory
    return memory._replace(tubes=memory.tubes._replace(history=memory.tubes.history.copy()))
