# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What is odd about a bag that can be read all the same, one line each."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from rodless_base.topics import VALVE_STATE
from rodless_lab.bags.reader import TopicMessages
from rodless_lab.runs.commands import SAME_SAMPLE
from rodless_lab.runs.measured_run import MeasuredRun

Array = npt.NDArray[np.float64]

# Of voltages that no sample takes, a larger share of the samples is no accident.
TOLERATED_SHARE = 0.01


def two_clocks(bag: Path, recorded: Sequence[TopicMessages]) -> str:
    """Say which topics are dated by when they were recorded beside some that have stamps."""
    without = [one.topic.name for one in recorded if not one.stamp_time.any()]
    if not without or len(without) == len(recorded):
        return ""
    stamped = next(one.topic.name for one in recorded if one.topic.name not in without)
    return (
        f"{bag}: {', '.join(without)}: without stamps, dated by when they were recorded and not as "
        f"{stamped} is; publish them with stamps"
    )


def voltages_left_out(
    bag: Path, positions: str, held: tuple[Array, Array], run: MeasuredRun
) -> str:
    """Say how many voltages the run, which has one from each sample to the next, has no room for.

    ``held`` are times (s), as those of ``run`` count, and the voltage (V) from each on.
    """
    when, voltage = held
    taken = np.searchsorted(when, run.time + SAME_SAMPLE, side="right") - 1
    others = np.setdiff1d(np.flatnonzero((when >= run.time[0]) & (when <= run.time[-1])), taken)
    sample = np.searchsorted(run.time, when[others] + SAME_SAMPLE, side="right") - 1
    count = int(np.count_nonzero(voltage[others] != run.voltage[sample]))
    if count <= TOLERATED_SHARE * len(run.time):
        return ""
    return (
        f"{bag}: {count} voltages of {VALVE_STATE} lie between the samples of {positions}, which "
        f"come every {1e3 * run.period:g} ms, and are left out; a replay departs: record positions "
        "as often"
    )


def set_points_left_out(bag: Path, messages: TopicMessages, usable: Sequence[int]) -> str:
    """Say how many set-points are no number: no controller takes them."""
    count = len(messages) - len(usable)
    if not count:
        return ""
    of = f"{count} of {len(messages)} set-points"
    return f"{bag}: {messages.topic.name}: {of} are no number in m and left out"
