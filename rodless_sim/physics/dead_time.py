# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Commands that reach the valve late: which holds when, sample period by sample period.

A period is cut where a command arrives within it. One that is like the one before changes nothing,
and cuts nothing.
"""

import numpy as np
import numpy.typing as npt

from rodless_base.constants import SECONDS_PER_NANOSECOND
from rodless_base.kernels import kernel_by_type, version_for
from rodless_sim.physics.course import course_at, spool_of
from rodless_sim.physics.equations import Inflows, inflows
from rodless_sim.physics.lands import AnyCourse, Course, Timed
from rodless_sim.physics.motion import advance_from
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.spool import Drive
from rodless_sim.physics.state import AnyMotion

Array = npt.NDArray[np.float64]


@kernel_by_type
def arriving(
    drive: Drive | tuple[()],  # noqa: ARG001
    commands: Array,
    k: int,
    period: int,  # noqa: ARG001
    closed: float,  # noqa: ARG001
) -> tuple[float, float]:
    """Return the command (V) at the valve as period ``k`` begins, and as it ends.

    ``commands`` are one per ``period`` (ns), up to that of period ``k`` at least. Before the first,
    the valve is at ``closed`` (V).
    """
    return commands[k], commands[k]


@version_for(Drive, arriving)
def _arriving(
    drive: Drive, commands: Array, k: int, period: int, closed: float
) -> tuple[float, float]:
    last = k - drive.dead_time // period
    late = commands[last] if last >= 0 else closed
    if drive.dead_time % period == 0:
        return late, late
    return commands[last - 1] if last >= 1 else closed, late


@kernel_by_type
def advance_period(
    plant: Plant,
    course: AnyCourse,
    state: AnyMotion,
    flows: Inflows,
    arrivals: tuple[float, float],  # noqa: ARG001
    period: int,
    tolerance: float,
) -> tuple[AnyMotion, AnyCourse, int]:
    """Advance by a sample period (ns) with what :func:`arriving` says, as ``advance_from`` does.

    The first of the ``arrivals`` is at the valve already: ``course`` and ``flows`` are its.
    """
    return advance_from(plant, course, state, flows, period * SECONDS_PER_NANOSECOND, tolerance)


@kernel_by_type
def until_arrival(drive: tuple[()], period: int) -> int:  # noqa: ARG001
    """Return how long after the start of a period (ns) a command arrives within it."""
    return 0


@version_for(Drive, until_arrival)
def _until_arrival(drive: Drive, period: int) -> int:
    return drive.dead_time % period


@version_for((Course, Timed), advance_period)
def _advance_period(
    plant: Plant,
    course: AnyCourse,
    state: AnyMotion,
    flows: Inflows,
    arrivals: tuple[float, float],
    period: int,
    tolerance: float,
) -> tuple[AnyMotion, AnyCourse, int]:
    """:func:`advance_period`, cut where a command arrives within it."""
    early, late = arrivals
    span = period if early == late else until_arrival(plant.drive, period)
    left = period - span
    # One call for both parts: each call site is a copy of nearly all the code there is to compile.
    while True:
        state, course, fault = advance_from(
            plant, course, state, flows, span * SECONDS_PER_NANOSECOND, tolerance
        )
        if fault != 0 or left == 0:
            return state, course, fault
        span, left = left, 0
        course = course_at(plant, spool_of(course), late)
        flows = inflows(plant, course, state)
