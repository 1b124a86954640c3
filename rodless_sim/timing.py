# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Plant time: integer nanoseconds."""

import numpy as np
import numpy.typing as npt

from rodless_base.constants import NANOSECONDS_PER_SECOND, SECONDS_PER_NANOSECOND
from rodless_base.one_line import shown
from rodless_base.parameters import Parameter, declare
from rodless_sim.single_number import single_number

PARAMETERS = declare(
    Parameter(
        "time.mode",
        "realtime",
        "",
        "realtime: paced by the wall clock; lockstep: one period for each command",
        "interface",
        choices=("realtime", "lockstep"),
        fixed=True,
        in_runs=False,
    ),
    Parameter(
        "time.period",
        1e-3,
        "s",
        "period of the published samples",
        "interface",
        1e-4,
        1.0,
        fixed=True,
        in_runs=False,
    ),
    Parameter(
        "time.tolerance",
        1.0,
        "",
        "error of an integration step, in units of 10 nm, 10 µm/s and 2 Pa",
        "interface",
        1e-3,
        1e3,
        fixed=True,
    ),
    Parameter(
        "time.speed",
        1.0,
        "",
        "plant seconds per wall-clock second (realtime)",
        "interface",
        1e-3,
        10.0,
        fixed=True,
        in_runs=False,
    ),
    Parameter(
        "time.duration",
        0.0,
        "s",
        "plant time at which the run ends, with the first sample from then on; 0 for never",
        "interface",
        0.0,
        1e6,
        fixed=True,
        in_runs=False,
    ),
    Parameter(
        "time.command_timeout",
        1.0,
        "s",
        "wall-clock time without a command after which lockstep says so and offers the sample "
        "again; longer than the controller takes for a sample",
        "interface",
        1e-2,
        1e3,
        fixed=True,
        in_runs=False,
    ),
    Parameter(
        "time.recorders",
        0,
        "",
        "recorders to wait for: with any, the plant starts once each of its topics has that many "
        "subscribers, joint_states one more",
        "interface",
        0,
        100,
        fixed=True,
        in_runs=False,
    ),
    Parameter(
        "time.scenario",
        "",
        "",
        "file of a scenario that the node follows, or the name of one that comes with the package "
        "(docs/faults.md); empty for none. Functions in Python take theirs as scenario=",
        "interface",
        fixed=True,
        in_runs=False,
    ),
    Parameter(
        "time.publish_clock",
        True,
        "",
        "publish plant time on /clock; switch off in all but one of several rigs (a rig in a "
        "namespace publishes its own on clock there, too)",
        "interface",
        fixed=True,
        in_runs=False,
    ),
)


# Times in ns are 64-bit integers: 292 years.
LONGEST_SPAN = 2**63 - 1

# In s: seconds of a computer, for a rig with all options.
LONGEST_STEP = 3600


def nanoseconds(duration: float, name: str = "duration") -> int:
    """Return ``duration`` (s) in whole nanoseconds.

    Raises ValueError, with the ``name`` of the time, unless that is positive and no longer than
    292 years; TypeError for what is no number.
    """
    span = single_number(duration, name, "seconds") * NANOSECONDS_PER_SECOND
    if not 0.5 < span <= LONGEST_SPAN:
        raise ValueError(
            f"{name} {shown(duration)} s refused: must be a positive number, from 1 ns to 292 years"
        )
    return round(span)


def step_nanoseconds(duration: float, name: str = "duration") -> int:
    """Return the ``duration`` (s) of one integrated step in whole nanoseconds.

    Raises as :func:`nanoseconds`, and ValueError for more than an hour: compiled, a step is one
    call, which hears neither Ctrl-C nor anything else until it is done.
    """
    span = nanoseconds(duration, name)
    if span > LONGEST_STEP * NANOSECONDS_PER_SECOND:
        raise ValueError(
            f"{name} {shown(duration)} s refused: one step lasts at most {LONGEST_STEP} s; take "
            "several"
        )
    return span


def sample_times(count: int, period: int) -> npt.NDArray[np.float64]:
    """Return the times in s, shape (count,), of samples ``period`` ns apart, the first at 0."""
    return np.asarray(np.arange(count) * period * SECONDS_PER_NANOSECOND, dtype=np.float64)
