# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Whether a run is another one, or one that is known already."""

from collections import Counter

import numpy as np
import numpy.typing as npt

from rodless_lab.runs.measured_run import MeasuredRun

Array = npt.NDArray[np.float64]

# In how many samples in a row two runs must agree to be held beside each other there.
IN_A_ROW = 8

# Of what moves in a run, more than this share is in another one only where it is that one. Runs of
# one rig that rest for long share up to a quarter.
SAME = 0.8


def mostly_known(run: MeasuredRun, known: MeasuredRun) -> bool:
    """Whether most of what moves in ``run`` stands in ``known`` too, sample by sample.

    So it is for a copy, one that lost samples or whose time was shifted, and a part that was cut
    out. Runs are held beside each other by their times, by their starts, and where they agree for
    a while.
    """
    times = np.rint(run.time / known.period), np.rint(known.time / known.period)
    readings = _readings(run), _readings(known)
    shifts = {0.0, times[1][0] - times[0][0], _common_shift(times, readings)}
    return any(
        _share(times[0] + shift, readings[0], times[1], readings[1]) > SAME for shift in shifts
    )


def _readings(run: MeasuredRun) -> Array:
    """Return pressures to 1 Pa and positions to 1 µm: the rest differs by the time base read on."""
    return np.rint(np.column_stack([run.pressure_a, run.pressure_b, 1e6 * run.position]))


def _common_shift(times: tuple[Array, Array], readings: tuple[Array, Array]) -> float:
    """Return by how many periods the courses that both have most often lie apart, 0 without any."""
    ours, theirs = map(_courses, readings)
    places = {course: place for place, course in enumerate(theirs)}
    found = Counter(
        times[1][places[course]] - times[0][place]
        for place, course in enumerate(ours)
        if course in places
    )
    return float(found.most_common(1)[0][0]) if found else 0.0


def _courses(readings: Array) -> list[bytes]:
    windows = np.lib.stride_tricks.sliding_window_view(readings, IN_A_ROW, axis=0)
    return [window.tobytes() for window in windows]


def _share(times: Array, readings: Array, known_times: Array, known: Array) -> float:
    """Return which share of the samples that differ from the one before is known at its time."""
    moves = np.append(False, np.any(np.diff(readings, axis=0) != 0.0, axis=1))
    if not moves.any():
        return 0.0
    place = np.searchsorted(known_times, times).clip(max=len(known_times) - 1)
    agrees = (known_times[place] == times) & np.all(known[place] == readings, axis=1)
    return float(np.mean(agrees[moves]))
