# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Positions that no rig has, and the unit that they may be in."""

import numpy as np

from rodless_control.parameters import REFERENCE
from rodless_lab.runs.measured_run import MeasuredRun

# Within these (m) a controller can be asked to hold a carriage, of however long a cylinder.
LIMITS = REFERENCE["reference.minimum"].minimum, REFERENCE["reference.maximum"].maximum


def off_any_rig(run: MeasuredRun) -> str:
    """Say which position of a run no rig can have, and in which unit it may be; empty for none."""
    low, high = LIMITS
    beyond = np.flatnonzero((run.position < low) | (run.position > high))
    if not len(beyond):
        return ""
    place = int(beyond[0])
    return (
        f"positions leave {low:g} to {high:g} m, at {run.time[place]:.3f} s with "
        f"{run.position[place]:.6g} m; they must be in m, and may be in mm"
    )
