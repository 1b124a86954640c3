# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Whether a run is another one, or one that is known already."""

import numpy as np
import numpy.typing as npt

from rodless_lab.runs.measured_run import MeasuredRun

Array = npt.NDArray[np.float64]

# In how many samples in a row two runs agree only where one is the other: the noise of their
# sensors, or that of the rig's moves, makes as many alike in no others.
IN_A_ROW = 20


def mostly_known(run: MeasuredRun, known: MeasuredRun) -> bool:
    """Whether most of what moves in ``run`` stands in ``known`` too, sample by sample.

    So it is for a copy, one that lost samples, and a part that was cut out.
    """
    there = {course.tobytes() for course in _courses(known.pressure_a)}
    moving = [course.tobytes() in there for course in _courses(run.pressure_a) if np.ptp(course)]
    return bool(moving) and float(np.mean(moving)) > 0.5


def _courses(values: Array) -> Array:
    # To 1 Pa: what was read onto another time base differs in its last bits.
    return np.lib.stride_tricks.sliding_window_view(np.rint(values), IN_A_ROW)
