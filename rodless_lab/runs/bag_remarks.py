# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What is odd about a bag that can be read all the same, one line each."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from rodless_base.constants import SECONDS_PER_NANOSECOND
from rodless_base.one_line import listed
from rodless_base.topics import FAULTS, PARAMETER_EVENTS, THROTTLED, VALVE_STATE
from rodless_lab.bags.metadata import BagError
from rodless_lab.bags.reader import Bag, TopicMessages
from rodless_lab.runs.commands import SAME_SAMPLE, SampleTimes
from rodless_lab.runs.measured_run import MeasuredRun
from rodless_lab.runs.recorded_drive import PRESSURE, held_in
from rodless_sim import RigParameters, faults

Array = npt.NDArray[np.float64]

# Of voltages that no sample takes, a larger share of the samples is no accident.
TOLERATED_SHARE = 0.01

PARAMETER_EVENT = "rcl_interfaces/msg/ParameterEvent"

FAULT_MESSAGE = "diagnostic_msgs/msg/DiagnosticArray"


# Of the samples of the positions, so small a share of those of another topic is a few words about
# all that lies between.
SMALL_SHARE = 1 / 20


def namespaces_with(bag: Bag, topic: str) -> list[str]:
    """Return where a bag has ``topic``, empty for the root.

    What the plant sends for views alone is no rig's.
    """
    found = [name.removesuffix(f"/{topic}") for name in bag if name.endswith(f"/{topic}")]
    return [one for one in found if one.rpartition("/")[2] != THROTTLED.rstrip("/")]


def other_rigs(bag: Bag, namespace: str, topic: str) -> str:
    """Say of which rigs a bag has positions beside those at the root, where no namespace is given.

    ``topic`` is that of the positions.
    """
    others = list(filter(None, namespaces_with(bag, topic)))
    if namespace or not others:
        return ""
    return f"{bag.path}: also holds {topic} of {listed(others)}; a namespace would choose that"


def several_senders(bag: Path, recorded: Sequence[TopicMessages]) -> str:
    """Say which topics several nodes have published: by the bag, or as their stamps have it."""
    twice = [one.topic.name for one in recorded if _share_of_stamps_again(one) > TOLERATED_SHARE]
    if twice:
        return (
            f"{bag}: {listed(twice)}: several messages have one stamp, as where several nodes "
            "publish under one name; they are mixed, and cannot be told apart"
        )
    counts = {one.topic.name: len(one.topic.qos) for one in recorded if len(one.topic.qos) > 1}
    if not counts:
        return ""
    said = ", ".join(f"{count} of {name}" for name, count in counts.items())
    return (
        f"{bag}: several publishers were known when the recording began ({said}), one of them "
        "perhaps killed before: what several send under one name is mixed"
    )


def _share_of_stamps_again(messages: TopicMessages) -> float:
    """Return of how many messages the stamp is that of the one before; 0 without stamps.

    Not of those that are the one before, which a lock-step plant offers again.
    """
    stamps = messages.stamp_time
    if len(stamps) < 2 or not stamps.any():
        return 0.0
    return float(np.mean((np.diff(stamps) == 0) & ~messages.repeated[1:]))


def far_apart(bag: Path, positions: TopicMessages, others: Sequence[TopicMessages]) -> str:
    """Say which topics have so few samples beside the positions that most of a run is between."""
    few = [one for one in others if len(one) < SMALL_SHARE * len(positions)]
    if not few:
        return ""
    counts = ", ".join(f"{len(one)} samples of {one.topic.name}" for one in few)
    return (
        f"{bag}: {counts} beside {len(positions)} of {positions.topic.name}: what lies between "
        "them is not known; pressures are interpolated, voltages held"
    )


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
    within = np.flatnonzero((when >= run.time[0]) & (when <= run.time[-1]))
    others = np.setdiff1d(within, taken)
    sample = np.searchsorted(run.time, when[others] + SAME_SAMPLE, side="right") - 1
    count = int(np.count_nonzero(voltage[others] != run.voltage[sample]))
    if count <= TOLERATED_SHARE * len(run.time):
        return ""
    as_often = len(within) <= (1.0 + TOLERATED_SHARE) * len(run.time)
    way = "give both the same stamps" if as_often else "record positions as often"
    return (
        f"{bag}: {count} voltages of {VALVE_STATE} lie between the samples of {positions}, which "
        f"come every {1e3 * run.period:g} ms, and are left out; a replay departs: {way}"
    )


def set_points_left_out(bag: Path, messages: TopicMessages, usable: Sequence[int]) -> str:
    """Say how many set-points are no number: no controller takes them."""
    count = len(messages) - len(usable)
    if not count:
        return ""
    of = f"{count} of {len(messages)} set-points"
    return f"{bag}: {messages.topic.name}: {of} are no number within ±1e100 m and left out"


def faults_in(bag: Bag, topic: str, begin: tuple[int, float], run: MeasuredRun) -> str:
    """Say which faults were active in a run, but for those that its other readings hold.

    ``topic`` is the plant's ``faults``; what another program publishes under that name says
    nothing. The times of the run count from ``begin`` (ns, and s after that).
    """
    recorded, (origin, start) = bag[topic], begin
    if recorded.topic.type_name != FAULT_MESSAGE:
        return ""
    held = set(held_in(run))
    last = float(run.time[-1])
    spans: dict[str, tuple[float, float]] = {}
    try:
        stamps = (recorded.stamp_time - origin) * SECONDS_PER_NANOSECOND - start
        active = [_named_faults(message) - held for message in recorded.messages]
    except BagError:
        return ""
    for since, until, names in zip(stamps, [*stamps[1:], math.inf], active, strict=True):
        if until > 0.0 and since <= last:
            now = max(float(since), 0.0), min(float(until), last)
            spans |= {name: (spans.get(name, now)[0], now[1]) for name in names}
    if not spans:
        return ""
    said = listed([f"{name} {low:.3f} to {high:.3f} s" for name, (low, high) in spans.items()])
    return (
        f"{bag.path}: {topic}: faults were active ({said}); a simulated rig has only those of "
        "its parameters"
    )


def changes_in(bag: Bag, namespace: str, sent: SampleTimes, start: float, run: MeasuredRun) -> str:
    """Say which parameters of the plant were set in a run, but for what its readings hold.

    What tells of that has no plant time: it is that of the sample before, by ``sent``, and counts
    from ``start`` (s). Of a rig in a namespace it may have come by another clock than its samples.
    """
    recorded = bag[PARAMETER_EVENTS]
    if recorded.topic.type_name != PARAMETER_EVENT:
        return ""
    try:
        events = [_set_in(message, namespace) for message in recorded.messages]
    except BagError:
        return ""
    held = {PRESSURE, *held_in(run)}
    if f"{namespace}/{FAULTS}" in bag:
        held |= faults.PARAMETERS.keys()
    times: dict[str, list[float]] = {}
    for when, names in zip(sent.plant_time(recorded) - start, events, strict=True):
        if namespace or 0.0 <= when < run.time[-1]:
            for name in sorted(names - held):
                times.setdefault(name, []).append(float(when))
    if not times:
        return ""
    said = listed([name if namespace else f"{name} {_times(when)}" for name, when in times.items()])
    return (
        f"{bag.path}: {PARAMETER_EVENTS}: parameters of the plant were set ({said}); a simulated "
        "rig keeps those it begins with"
    )


def _set_in(message: Any, namespace: str) -> set[str]:
    """Return what of the runs of a plant in ``namespace`` a message says was set."""
    if message.node.rpartition("/")[0] != namespace:
        return set()
    changed = {parameter.name for parameter in message.changed_parameters}
    declarations = RigParameters.DECLARATIONS
    return {name for name in changed & declarations.keys() if declarations[name].in_runs}


def _times(when: Sequence[float]) -> str:
    again = f", the last of {len(when)} times at {when[-1]:.3f} s" if len(when) > 1 else ""
    return f"at {when[0]:.3f} s{again}"


def _named_faults(message: Any) -> set[str]:
    named = {value.key for status in message.status for value in status.values}
    return named & faults.PARAMETERS.keys()
