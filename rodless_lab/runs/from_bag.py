# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Read a run from a rosbag2 bag of the rig's topics, this simulator's or a real rig's."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from rodless_base.constants import (
    CARRIAGE,
    MAXIMUM_VOLTAGE,
    MINIMUM_VOLTAGE,
    NANOSECONDS_PER_SECOND,
    SECONDS_PER_NANOSECOND,
    SPOOL,
)
from rodless_base.one_line import shown
from rodless_base.topics import (
    FAULTS,
    JOINT_STATES,
    PARAMETER_EVENTS,
    PRESSURES,
    SETPOINT,
    VALVE_STATE,
    VALVE_VOLTAGE,
)
from rodless_lab.bags.metadata import BagError
from rodless_lab.bags.reader import Bag, TopicMessages, read_bag
from rodless_lab.runs.bag_remarks import (
    changes_in,
    far_apart,
    faults_in,
    namespaces_with,
    other_rigs,
    set_points_left_out,
    several_senders,
    two_clocks,
    voltages_left_out,
)
from rodless_lab.runs.commands import SAME_SAMPLE, Commands, SampleTimes, held_from
from rodless_lab.runs.joints import JointMessages, joint_messages, joint_values
from rodless_lab.runs.measured_run import MeasuredRun, RunError, Setpoint
from rodless_lab.runs.missing_samples import missing_samples
from rodless_lab.runs.off_any_rig import off_any_rig

Array = npt.NDArray[np.float64]
Times = npt.NDArray[np.int64]

# In ns, a day: what is later than that counts from its first stamp.
LONG_TIME = 86_400 * NANOSECONDS_PER_SECOND

# A gap between position samples longer than this many periods is a hole in the recording.
LONGEST_GAP = 20.0

# By how many times each span is longer, over which the period is measured, than the one before.
LONGER = 4

# Stamps are whole nanoseconds: what is closer (s) to an even time differs by rounding alone.
SAME_INSTANT = 5e-10

# Beyond it, in m, Pa or V, nothing can be computed with or drawn.
LARGEST_READING = 1e100


def read_run(path: str | Path, namespace: str = "") -> MeasuredRun:
    """Read position, pressures and voltage from a bag of the rig's topics; time begins at 0.

    Stamped topics count by their stamps, the voltage too where the plant's ``valve/state`` was
    recorded. Where only ``valve/voltage`` was, which has none, a command is taken to act from the
    sample on that was sent last before it. All are put on the evenly spaced time base of the
    positions.

    Parameters
    ----------
    path
        The bag's folder, or one of its storage files.
    namespace
        Namespace of the rig, such as ``/rig1``.

    Returns
    -------
    MeasuredRun
        Arrays on one time base, SI; ``save`` and ``to_dataframe`` write them elsewhere.

    Raises
    ------
    RunError
        Names topic and place, for a bag that is missing, damaged or empty, lacks a topic, holds
        values that are not finite, or time going backwards. Where commands cannot be dated to a
        sample, ``doubt`` of the run says why, and the run cannot be replayed; where samples were
        lost, ``missing`` says which, and ``remarks`` what else is odd.

    Examples
    --------
    >>> run = read_run("run1")
    >>> run.save("run1.csv")
    """
    return read_run_and_setpoint(path, namespace)[0]


def read_run_and_setpoint(
    path: str | Path, namespace: str = ""
) -> tuple[MeasuredRun, Setpoint | None]:
    """Read a run as :func:`read_run` does, and its set-points if they were recorded."""
    found = read_recording(path, namespace)
    return found.run, found.setpoint


def read_recording(path: str | Path, namespace: str = "") -> "Recording":
    """Read a run as :func:`read_run` does, and where it lies in the bag."""
    prefix = _prefix(namespace)
    with naming(path):
        return recording_in(read_bag(path), prefix)


def _prefix(namespace: str) -> str:
    """Return what stands before the topics of a rig."""
    if not isinstance(namespace, str):
        raise TypeError(f"{shown(namespace)} refused, must be a namespace such as '/rig1'")
    name = namespace.strip("/")
    return f"/{name}" if name else ""


@contextmanager
def naming(path: str | Path) -> Iterator[None]:
    """Turn what is wrong with the bag at ``path`` into a RunError that names it."""
    try:
        yield
    except (BagError, RunError) as error:
        text = str(error)
        named = str(path) in text or shown(path) in text
        raise RunError(text if named else f"{path}: {text}") from error


@dataclass(frozen=True)
class Recording:
    """A run in a bag, which begins ``start`` (s) after ``origin`` (ns, by the bag's stamps).

    ``sent`` tells when, after ``origin``, what has no stamp was sent.
    """

    run: MeasuredRun
    setpoint: Setpoint | None
    origin: int
    start: float
    sent: SampleTimes

    @property
    def begin(self) -> float:
        """Where the run begins, s, as the bag's stamps have it."""
        return self.origin * SECONDS_PER_NANOSECOND + self.start

    def stamps_of(self, messages: TopicMessages) -> Array:
        """Return the stamps of ``messages`` in s of the run."""
        return stamps_of(messages, self.origin) - self.start

    def numbers_of(self, messages: TopicMessages) -> tuple[Array, Array]:
        """Return times in s of the run, and values, of a topic of plain numbers."""
        when, values = plain_numbers(messages, self.sent)
        return when - self.start, values


def recording_in(bag: Bag, namespace: str) -> Recording:
    """Return what :func:`read_run_and_setpoint` reads; raises RunError and BagError."""
    carriage = _carriage(bag, namespace)
    joint = carriage.messages
    origin = _origin(joint)
    time = stamps_of(joint, origin)
    position = _checked(joint, joint_values(carriage, "position"), time)
    pressures = []
    for topic in PRESSURES.values():
        messages = _recorded(bag, namespace, topic)
        own = stamps_of(messages, origin)
        values = _checked(messages, _field(messages, "fluid_pressure"), own)
        pressures.append(_once(messages, own, values))
    sent = SampleTimes(joint, time)
    held = _held(bag, namespace, origin)
    voltage, doubt = (held, "") if held is not None else _commanded(bag, namespace, sent)
    run = _on_one_base(_once(joint, time, position), pressures, voltage)
    start = float(run.time[0])
    beside = _beside(bag, namespace)
    setpoint, refused = _setpoint(bag, namespace, sent, start)
    remarks = [
        *bag.notes,
        setpoint.doubt if setpoint else "",
        refused,
        two_clocks(bag.path, [joint, *beside]),
        other_rigs(bag, namespace, JOINT_STATES),
        several_senders(bag.path, [joint, *beside]),
        far_apart(bag.path, joint, beside),
        voltages_left_out(bag.path, joint.topic.name, held, run) if held is not None else "",
    ]
    run = replace(run, time=run.time - start, doubt=doubt, commanded=held is None)
    remarks += [f"{bag.path}: {namespace}/{strange}" for strange in off_any_rig(run)]
    if (name := f"{namespace}/{FAULTS}") in bag:
        remarks.append(faults_in(bag, name, (origin, start), run))
    if PARAMETER_EVENTS in bag:
        remarks.append(changes_in(bag, namespace, sent, start, run))
    run = replace(
        run,
        missing=_missing(bag, namespace, (origin, start), joint, sent),
        remarks=tuple(filter(None, remarks)),
    )
    return Recording(run, setpoint, origin, start, sent)


def _setpoint(
    bag: Bag, namespace: str, sent: SampleTimes, start: float
) -> tuple[Setpoint | None, str]:
    """Set-points by times from ``start`` (s) on, if they were recorded, and which are left out."""
    name = f"{namespace}/{SETPOINT}"
    if name not in bag or not len(bag[name]):
        return None, ""
    messages = bag[name]
    usable = np.flatnonzero(np.abs(_field(messages, "data")) <= LARGEST_READING).tolist()
    left_out = set_points_left_out(bag.path, messages, usable)
    if not usable:
        return None, left_out
    when, wanted = plain_numbers(messages.at(usable), sent)
    doubt = ""
    if sent.why_useless:
        doubt = (
            f"{bag.path}: {name}: {sent.why_useless}, so it is not known when set-points were "
            "given; record with `rodless record`"
        )
    return Setpoint(when - start, wanted, doubt), left_out


def _beside(bag: Bag, namespace: str) -> list[TopicMessages]:
    """Return what of the plant was recorded beside its positions and has a header."""
    names = [f"{namespace}/{topic}" for topic in (*PRESSURES.values(), VALVE_STATE)]
    return [bag[name] for name in names if name in bag and len(bag[name])]


def _carriage(bag: Bag, namespace: str) -> JointMessages:
    return joint_messages(_recorded(bag, namespace, JOINT_STATES), CARRIAGE)


def _missing(
    bag: Bag, namespace: str, begin: tuple[int, float], joint: TopicMessages, sent: SampleTimes
) -> str:
    """Say which samples were lost on the way into the bag, if any, and how to lose none.

    Times count from ``begin`` (ns, and s after that), as those of the run do.
    """
    origin, start = begin
    stamps = {
        found.topic.name: _seconds(found.stamp_time, origin) - start
        for found in (joint, *_beside(bag, namespace))
    }
    lost = missing_samples(stamps, pace=1.0 if sent.why_useless else max(sent.speed, 1.0))
    if not lost:
        return ""
    departs = "; a replay departs where the valve's were lost" if VALVE_STATE in lost else ""
    return (
        f"{bag.path}: {lost}{departs}; record with `rodless record`, or as docs/bags.md says, on a "
        "machine with time to spare"
    )


def read_commands(path: str | Path, namespace: str = "") -> Commands:
    """Read the commands of a bag: which sample each answers, how fast, and when the valve followed.

    Parameters
    ----------
    path
        The bag's folder, or one of its storage files.
    namespace
        Namespace of the rig, such as ``/rig1``.

    Returns
    -------
    Commands
        Arrays, one entry per command; times are plant time as it is in the stamps.

    Raises
    ------
    RunError
        For a bag that is missing, damaged, or lacks ``joint_states`` or ``valve/voltage``, or whose
        times do not tell its samples apart.

    Examples
    --------
    >>> commands = read_commands("run1")
    >>> commands.sample[:3].tolist(), float(commands.latency.max())
    ([0, 1, 2], 0.0)
    >>> commands.save("commands.csv")
    """
    prefix = _prefix(namespace)
    with naming(path):
        return _commands(read_bag(path), prefix)


def _commands(bag: Bag, namespace: str) -> Commands:
    joint = _carriage(bag, namespace).messages
    sent = SampleTimes(joint, stamps_of(joint))
    messages = _recorded(bag, namespace, VALVE_VOLTAGE)
    if sent.why_useless:
        raise RunError(
            f"{messages.topic.name}: {sent.why_useless}, so it is not known which one each command "
            "answers"
        )
    time, voltage = sent.plant_time(messages), _field(messages, "data")
    held = _held(bag, namespace) or (np.empty(0), np.empty(0))
    limits = (MINIMUM_VOLTAGE, MAXIMUM_VOLTAGE)
    return Commands(
        time,
        voltage,
        sent.answered(messages),
        sent.latency(messages),
        held_from(time, voltage, held, limits),
    )


def _held(bag: Bag, namespace: str, origin: int = 0) -> tuple[Array, Array] | None:
    """Times (s) and the voltage (V) that the valve held from each on, if that was recorded.

    A message tells what was held up to its stamp, since that of the message before.
    """
    name = f"{namespace}/{VALVE_STATE}"
    if name not in bag or not len(bag[name]):
        return None
    spool = joint_messages(bag[name], SPOOL)
    stamps = stamps_of(spool.messages, origin)
    effort = _checked(spool.messages, joint_values(spool, "effort"), stamps)
    time, voltage = _once(spool.messages, stamps, effort)
    return (time[:-1], voltage[1:]) if len(time) > 1 else None


def _once(messages: TopicMessages, stamps: Array, values: Array) -> tuple[Array, Array]:
    """Leave out what a lock-step plant has offered again: it is nothing new."""
    new = ~messages.repeated
    return stamps[new], values[new]


def _commanded(bag: Bag, namespace: str, sent: SampleTimes) -> tuple[tuple[Array, Array], str]:
    """Times (s) from which which voltage (V) was asked for, and why to doubt them, if so."""
    commands = _recorded(bag, namespace, VALVE_VOLTAGE)
    doubt = sent.doubt(commands)
    if doubt:
        doubt = (
            f"{bag.path}: {commands.topic.name}: {doubt}, so it is not known when the valve took "
            f"them; record {VALVE_STATE} too, as the plant publishes it"
        )
    if sent.why_useless:  # not even where the run begins
        raise RunError(doubt)
    return plain_numbers(commands, sent), doubt


def plain_numbers(messages: TopicMessages, sent: SampleTimes) -> tuple[Array, Array]:
    """Return plant times (s) and values of a topic of plain numbers; raises RunError for others."""
    _refuse_backwards(messages, messages.time)
    when = sent.plant_time(messages)
    return when, _checked(messages, _field(messages, "data"), when)


def _recorded(bag: Bag, namespace: str, topic: str) -> TopicMessages:
    name = f"{namespace}/{topic}"
    if name not in bag:
        _refuse_namespace(bag, topic)
    messages = bag[name]
    if not len(messages):
        raise RunError(f"{messages.topic.name} holds no message")
    return messages


def _refuse_namespace(bag: Bag, topic: str) -> None:
    """Raise RunError where the ``topic`` was recorded of rigs in other namespaces."""
    if others := namespaces_with(bag, topic):
        where = " or ".join(one or "/" for one in others)
        raise RunError(f"{topic} was recorded of a rig in {where}; give that as the namespace")


def stamps_of(messages: TopicMessages, origin: int = 0) -> Array:
    """Stamps in s after ``origin`` (ns); log times where the publisher left the stamps at zero."""
    stamps = _seconds(_stamp_times(messages), origin)
    _refuse_backwards(messages, stamps)
    return stamps


def _seconds(times: Times, origin: int) -> Array:
    """Return ``times`` (ns) in s after ``origin`` (ns)."""
    return np.asarray((times - origin) * SECONDS_PER_NANOSECOND, dtype=np.float64)


def _stamp_times(messages: TopicMessages) -> Times:
    return messages.stamp_time if messages.stamp_time.any() else messages.log_time


def _origin(messages: TopicMessages) -> int:
    """Return the instant (ns) from which on a run's times resolve nanoseconds as seconds.

    Those of a wall clock do not: after half a century a number of seconds has steps of 0.2 µs.
    """
    first = int(_stamp_times(messages)[0])
    return first if first > LONG_TIME else 0


def _refuse_backwards(messages: TopicMessages, time: Array) -> None:
    back = np.flatnonzero(np.diff(time) < 0.0)
    if len(back):
        place = int(back[0]) + 1
        raise RunError(
            f"{messages.topic.name}: time goes backwards at message {place}, from "
            f"{time[place - 1]:.6f} s to {time[place]:.6f} s; was the plant reset? A run is read "
            "from its start on: record each by itself (read_bag reads this one as it is)"
        )


def _field(messages: TopicMessages, name: str) -> Array:
    fields = messages.fields
    if name not in fields or fields[name].ndim != 1:
        raise RunError(
            f"{messages.topic.name}: {messages.topic.type_name} has no {name} of one number"
        )
    return np.asarray(fields[name], dtype=np.float64)


def _checked(messages: TopicMessages, values: Array, time: Array) -> Array:
    bad = np.flatnonzero(~(np.abs(values) <= LARGEST_READING))  # NaN, too
    if len(bad):
        place = int(bad[0])
        raise RunError(
            f"{messages.topic.name}: message {place}, at {time[place]:.6f} s, holds "
            f"{values[place]:g}, must be a number within ±{LARGEST_READING:g}"
        )
    return values


def _on_one_base(
    position: tuple[Array, Array],
    pressures: list[tuple[Array, Array]],
    voltage: tuple[Array, Array],
) -> MeasuredRun:
    start = max(position[0][0], voltage[0][0] - SAME_SAMPLE, *(time[0] for time, _ in pressures))
    end = min(position[0][-1], *(time[-1] for time, _ in pressures))
    inside = position[0][(position[0] >= start) & (position[0] <= end)]
    if len(inside) < 2:
        raise RunError("its topics were not recorded at the same time")
    period = _period(inside)
    if period <= 0.0:
        raise RunError("most of the positions share one time")
    gaps = np.diff(inside)
    if gaps.max() > LONGEST_GAP * period:
        raise RunError(
            f"no position for {gaps.max():.3f} s after {inside[np.argmax(gaps)]:.3f} s, "
            f"which come every {period:.4f} s otherwise"
        )
    time = np.linspace(inside[0], inside[-1], round((inside[-1] - inside[0]) / period) + 1)
    last = np.searchsorted(voltage[0], time + SAME_SAMPLE, side="right") - 1
    pressure_a, pressure_b, supply = (_readings_at(time, *pressure) for pressure in pressures)
    return MeasuredRun(
        time=time,
        position=_readings_at(time, *position),
        pressure_a=pressure_a,
        pressure_b=pressure_b,
        supply_pressure=supply,
        voltage=voltage[1][np.maximum(last, 0)],
    )


def _period(time: Array) -> float:
    """Return the time (s) from one sample to the next, of most; 0 where most share one.

    Stamps jitter: over many samples that counts less, and how many periods each span of them has,
    with what was lost here and there, is known from shorter ones.
    """
    steps = np.diff(time)
    most = float(np.quantile(steps, 0.5, method="higher"))  # none between 0 and a period
    if most <= 0.0:
        return 0.0
    # Without the steps over a lost sample, which would lengthen the others' median.
    period = float(np.median(steps[(steps > 0.0) & (steps < 1.5 * most)]))
    span = 2
    while span < len(time):
        apart = time[span:] - time[:-span]
        period = float(np.median(apart / np.maximum(np.rint(apart / period), 1.0)))
        span *= LONGER
    return period


def _readings_at(time: Array, stamps: Array, values: Array) -> Array:
    """Interpolate readings; those of an instant itself stay as they are, to the last bit."""
    found = np.interp(time, stamps, values)
    nearest = np.clip(np.searchsorted(stamps, time - SAME_INSTANT), 0, len(stamps) - 1)
    same = np.abs(stamps[nearest] - time) <= SAME_INSTANT
    found[same] = values[nearest[same]]
    return found
