# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Tubes between valve and chambers: air that the valve has passed arrives later, and presses back.

What passes the valve is at the chamber after the time that sound takes (Richer and Hurmuzlu 2000,
neglecting reflections),

    ṁ(L, t) = ṁ(0, t − τ)                           τ = L/c,  c = √(κ R T_s)

Their factor φ < 1 for friction would lose mass. Here all air arrives, and m = ∫ ṁ over the last τ
is in the tube. Friction shows where it acts, as a fall of pressure along the tube:

    P_v² = P_e² ± f (L/D) (ṁ/A)² R T_s              f = max(64/Re, 0.3164/Re^¼)

for isothermal flow, by Hagen and Poiseuille or by Blasius, whichever is larger. The tube's end at
the valve has the pressure P_e that the chamber will have once the air in the tube has arrived, all
other changes of the chamber going on as they do now,

    P_e = P + τ (dP/dt − K ṁ(t − τ)) + K m          K = κ R T_s/V

so that pressure and flow travel alike. With P itself, a wide open valve would fill a small chamber
past the supply, and swing on for ever.

All that a chamber is given in the next τ is in the tube already: a known course in time, in steps
no longer than τ (the method of steps). The states of the rig stay what they are. Of P_e, a part
that hardly changes by itself is kept apart, D = P_e − K M with M the mass that the valve has passed
so far: what remains is one equation for M at the valve,

    dM/dt = ṁ(P_v)        P_e = D + K M

solved behind each step of the rig by the L-stable SDIRK method of order 2. The history is M with
its slopes, cubic between its nodes: what arrives over any step is the difference of two M, and no
air is lost.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from rodless_base.kernels import kernel, outlined_kernel
from rodless_sim.physics.air import Air
from rodless_sim.physics.lands import Lands
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import Inflow, inflow_a, inflow_b

Array = npt.NDArray[np.float64]

SDIRK = 1.0 - math.sqrt(0.5)

# Nearer than this two instants are one: what plant time resolves.
SAME = 1e-9  # s

# Of a step at the valve: in terms of the chamber's time constant there, and of the delay.
LARGEST_ANGLE = 0.25
LARGEST_SHARE = 0.25
MOST_PARTS = 64

# How near a pressure at the valve must balance.
NEAR = 1e-6  # Pa
MOST_TRIALS = 60

# Columns of the history: time, then of each tube M and its slope before and after that time.
TIME, A, B = 0, 1, 4
COLUMNS = 7
FIRST_ROWS = 64


class End(NamedTuple):
    """A tube's end at the valve."""

    mass: float  # kg, M: what has passed the valve since the start
    flow: float  # kg/s
    level: float  # Pa, D
    stiffness: float  # Pa/kg, K
    pressure: float  # Pa, P_v
    rate: float  # 1/s, how fast flow and pressure at this end balance


class Tubes(NamedTuple):
    """What is in the tubes."""

    history: Array  # (rows, COLUMNS)
    rows: int  # in use
    last: int  # of the rows not later than the delay ago
    a: End
    b: End


class Window(NamedTuple):
    """What arrives at a chamber during a step: a parabola of the right mass."""

    begin: float  # kg/s
    end: float  # kg/s
    mean: float  # kg/s


@kernel
def share_of(window: Window, share: float) -> float:
    """Flow in kg/s at a share of the step."""
    bow = 6.0 * share * (1.0 - share)
    begin = (1.0 - share) * (1.0 - 3.0 * share)
    return bow * window.mean + begin * window.begin + share * (3.0 * share - 2.0) * window.end


@kernel
def friction_square(plant: Plant, flow: float) -> float:
    """Return P_v² − P_e² in Pa² for a flow (kg/s) from the valve to the chamber."""
    tube, air = plant.tubes, plant.air
    size = abs(flow)
    laminar = 128.0 * air.viscosity / (math.pi * tube.diameter**4) * size
    reynolds = 4.0 * size / (math.pi * tube.diameter * air.viscosity)
    along = 2.0 * air.gas_constant * air.temperature * tube.length
    # max(64/Re, 0.3164/Re^¼) as a multiple of the first.
    found: float = along * laminar * max(1.0, 0.3164 / 64.0 * reynolds**0.75)
    return found if flow >= 0.0 else -found


@kernel
def friction_slope(plant: Plant, flow: float, square: float) -> float:
    """Return how :func:`friction_square`, which is ``square``, grows with the flow: Pa²·s/kg."""
    tube, air = plant.tubes, plant.air
    along = 2.0 * air.gas_constant * air.temperature * tube.length
    laminar = along * 128.0 * air.viscosity / (math.pi * tube.diameter**4)
    size = abs(flow)
    # Laminar it grows as the flow, else as its power of 1.75.
    return laminar if abs(square) <= laminar * size else 1.75 * abs(square) / size


@kernel
def stiffness(air: Air, volume: float) -> float:
    """K in Pa/kg of a chamber of ``volume`` (m³)."""
    return air.chamber_index * air.gas_constant * air.temperature / volume


@kernel
def through_valve(plant: Plant, lands: Lands, second: bool, pressure: float) -> Inflow:
    """Flow from the valve into the tube of chamber A, or B: the ``second``."""
    if second:
        return inflow_b(plant, lands, pressure)
    return inflow_a(plant, lands, pressure)


@outlined_kernel
def balanced(
    plant: Plant, lands: Lands, second: bool, beside: float, per_flow: float, pressure: float
) -> tuple[float, float, float]:
    """Return flow (kg/s) and pressure (Pa) at the valve, and how the flow falls with it.

    The tube's end has the pressure ``beside`` + ``per_flow`` · flow (Pa, Pa·s/kg). ``pressure`` is
    where the search begins. What is left over grows with the pressure at the valve, and its root
    lies between supply and ambient.
    """
    beside = max(beside, 1.0)
    low, high = min(plant.ambient_pressure, beside), max(plant.supply_pressure, beside)
    pressure = min(max(pressure, low), high)
    found = through_valve(plant, lands, second, pressure)
    for _ in range(MOST_TRIALS):
        square = friction_square(plant, found.mass_flow)
        end = max(beside + per_flow * found.mass_flow, 0.0)
        left = pressure * pressure - square - end * end
        if left > 0.0:
            high = pressure
        else:
            low = pressure
        along = friction_slope(plant, found.mass_flow, square) + 2.0 * end * per_flow
        trial = pressure - left / (2.0 * pressure - along * found.by_pressure)
        if not low <= trial <= high:
            trial = 0.5 * (low + high)
        change = abs(trial - pressure)
        pressure = trial
        found = through_valve(plant, lands, second, pressure)
        if change < NEAR:
            break
    return found.mass_flow, pressure, -found.by_pressure


@kernel
def opened(plant: Plant, lands: Lands, second: bool, end: End) -> End:
    """Return the end once the valve's openings are ``lands``: the same however often it is asked.

    So the search does not begin where one for the same openings has ended.
    """
    beside = end.level + end.stiffness * end.mass
    flow, pressure, slope = balanced(plant, lands, second, beside, 0.0, beside)
    return End(end.mass, flow, end.level, end.stiffness, pressure, end.stiffness * slope)


@kernel
def filled(
    now: Plant,
    then: Plant,
    middle: Lands,
    last: Lands,
    second: bool,
    end: End,
    level: float,
    stiff: float,
    step: float,
) -> End:
    """Return the end ``step`` s later, when D and K are ``level`` and ``stiff``.

    ``now`` and ``then`` are the plant at the stages of the method, ``middle`` and ``last`` the
    valve's openings.
    """
    own = SDIRK * step
    early_level = end.level + SDIRK * (level - end.level)
    early = end.stiffness + SDIRK * (stiff - end.stiffness)
    first, pressure, _ = balanced(
        now, middle, second, early_level + early * end.mass, early * own, end.pressure
    )
    mass = end.mass + (step - own) * first
    flow, pressure, slope = balanced(
        then, last, second, level + stiff * mass, stiff * own, pressure
    )
    return End(mass + own * flow, flow, level, stiff, pressure, stiff * slope)


@kernel
def parts_of(end: End, step: float) -> float:
    """Into how many parts a step is cut for an end."""
    return step * end.rate / LARGEST_ANGLE


@kernel
def hermite(history: Array, row: int, column: int, time: float) -> tuple[float, float]:
    """Return M (kg) and its slope (kg/s) at ``time`` between ``row`` and the next one."""
    length = history[row + 1, TIME] - history[row, TIME]
    before, after = history[row, column], history[row + 1, column]
    if length <= 0.0:
        return after, history[row, column + 2]
    share = min(max((time - history[row, TIME]) / length, 0.0), 1.0)
    window = Window(
        history[row, column + 2], history[row + 1, column + 1], (after - before) / length
    )
    one, other = share * (1.0 - share) * (1.0 - share), share * share * (1.0 - share)
    mass = before + share * share * (3.0 - 2.0 * share) * (after - before)
    return mass + length * (one * window.begin - other * window.end), share_of(window, share)


@kernel
def row_at(tubes: Tubes, time: float, from_before: bool) -> int:
    """Return the row whose part of the history holds ``time``.

    Of two parts that meet there it is the first if looked at ``from_before``.
    """
    near = -SAME if from_before else SAME
    row = tubes.last
    while row + 2 < tubes.rows and tubes.history[row + 1, TIME] <= time + near:
        row += 1
    return row


@kernel
def next_jump(tubes: Tubes, time: float) -> float:
    """Return the next instant (s) after ``time`` at which a flow into a tube has jumped."""
    history = tubes.history
    for row in range(tubes.last + 1, tubes.rows):
        jumps = (
            history[row, A + 1] != history[row, A + 2] or history[row, B + 1] != history[row, B + 2]
        )
        if jumps and history[row, TIME] > time + SAME:
            return float(history[row, TIME])
    return math.inf


@outlined_kernel
def with_room(tubes: Tubes) -> Tubes:
    """Return the same history with room for one more row: without what has arrived, or longer."""
    history, last, count = tubes.history, tubes.last, tubes.rows
    kept, room = count - last, history
    if 2 * kept > history.shape[0]:
        room = np.empty((2 * history.shape[0], COLUMNS))
    # Number by number: whole rows would have the texts of numpy's errors compiled with them.
    for row in range(kept):
        for column in range(COLUMNS):
            room[row, column] = history[last + row, column]
    return Tubes(room, kept, 0, tubes.a, tubes.b)


@kernel
def noted(tubes: Tubes, time: float, a: End, b: End) -> Tubes:
    """Return the history with what has passed the valve up to ``time`` (s)."""
    if tubes.rows == tubes.history.shape[0]:
        tubes = with_room(tubes)
    row = tubes.history[tubes.rows]
    row[TIME] = time
    row[A], row[A + 1], row[A + 2] = a.mass, a.flow, a.flow
    row[B], row[B + 1], row[B + 2] = b.mass, b.flow, b.flow
    return Tubes(tubes.history, tubes.rows + 1, tubes.last, a, b)
