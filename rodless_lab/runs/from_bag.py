"""Read a run from a rosbag2 bag of the rig's topics, this simulator's or a real rig's."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from rodless_base.constants import CARRIAGE
from rodless_base.frames import carriage_among
from rodless_base.topics import JOINT_STATES, PRESSURES, SETPOINT, VALVE_VOLTAGE
from rodless_lab.bags.metadata import BagError
from rodless_lab.bags.reader import Bag, TopicMessages, read_bag
from rodless_lab.runs.measured_run import MeasuredRun, RunError, Setpoint

Array = npt.NDArray[np.float64]


# A gap between position samples longer than this many periods is a hole in the recording.
LONGEST_GAP = 20.0


def read_run(path: str | Path, namespace: str = "") -> MeasuredRun:
    """Read position, pressures and voltage from a bag of the rig's topics; time begins at 0.

    Stamped topics count by their stamps; the voltage, which has none, by its log time, shifted as
    those of the positions are from their stamps. All are put on the evenly spaced time base of the
    positions.

    Parameters
    ----------
    path
        The bag's folder, or one of its storage files (MCAP).
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
        values that are not finite, or time going backwards.

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
    try:
        bag = read_bag(path)
        return _run(bag, namespace.rstrip("/"))
    except (BagError, RunError) as error:
        text = str(error)
        raise RunError(text if str(path) in text else f"{path}: {text}") from error


def _run(bag: Bag, namespace: str) -> tuple[MeasuredRun, Setpoint | None]:
    joint = _recorded(bag, namespace, JOINT_STATES)
    time = _stamps(joint)
    position = _checked(joint, _position(joint), time)
    pressures = []
    for topic in PRESSURES.values():
        messages = _recorded(bag, namespace, topic)
        own = _stamps(messages)
        pressures.append((own, _checked(messages, _field(messages, "fluid_pressure"), own)))
    offset = float(np.median(joint.time - time))
    voltage = _unstamped(_recorded(bag, namespace, VALVE_VOLTAGE), offset)
    run = _on_one_base((time, position), pressures, voltage)
    setpoint = None
    if f"{namespace}/{SETPOINT}" in bag and len(bag[f"{namespace}/{SETPOINT}"]):
        when, wanted = _unstamped(_recorded(bag, namespace, SETPOINT), offset)
        setpoint = Setpoint(when - run.time[0], wanted)
    return replace(run, time=run.time - run.time[0]), setpoint


def _unstamped(messages: TopicMessages, offset: float) -> tuple[Array, Array]:
    """Times, ``offset`` s before the log times, and values of a topic of plain numbers."""
    _refuse_backwards(messages, messages.time)
    when = messages.time - offset
    return when, _checked(messages, _field(messages, "data"), when)


def _recorded(bag: Bag, namespace: str, topic: str) -> TopicMessages:
    messages = bag[f"{namespace}/{topic}"]
    if not len(messages):
        raise RunError(f"{messages.topic.name} holds no message")
    return messages


def _stamps(messages: TopicMessages) -> Array:
    """Stamps in s; log times where the publisher left the stamps at zero."""
    stamps = messages.stamp if messages.stamp.any() else messages.time
    _refuse_backwards(messages, stamps)
    return stamps


def _refuse_backwards(messages: TopicMessages, time: Array) -> None:
    back = np.flatnonzero(np.diff(time) < 0.0)
    if len(back):
        place = int(back[0]) + 1
        raise RunError(
            f"{messages.topic.name}: time goes backwards at message {place}, from "
            f"{time[place - 1]:.6f} s to {time[place]:.6f} s; was the plant reset?"
        )


def _field(messages: TopicMessages, name: str) -> Array:
    fields = messages.fields
    if name not in fields:
        raise RunError(f"{messages.topic.name}: {messages.topic.type_name} has no {name}")
    return np.asarray(fields[name], dtype=np.float64)


def _position(messages: TopicMessages) -> Array:
    """Position of the carriage, or of the only joint."""
    positions = _field(messages, "position")
    names = list(messages.messages[0].name)
    if positions.ndim != 2 or not positions.shape[1]:
        raise RunError(f"{messages.topic.name}: its messages carry no position")
    carriage = carriage_among(names)
    if carriage is not None:
        return np.asarray(positions[:, names.index(carriage)])
    if positions.shape[1] == 1:
        return np.asarray(positions[:, 0])
    raise RunError(f"{messages.topic.name}: no joint {CARRIAGE!r} among {', '.join(names)}")


def _checked(messages: TopicMessages, values: Array, time: Array) -> Array:
    bad = np.flatnonzero(~np.isfinite(values))
    if len(bad):
        place = int(bad[0])
        raise RunError(
            f"{messages.topic.name}: message {place}, at {time[place]:.6f} s, holds {values[place]}"
        )
    return values


def _on_one_base(
    position: tuple[Array, Array],
    pressures: list[tuple[Array, Array]],
    voltage: tuple[Array, Array],
) -> MeasuredRun:
    # A command belongs to the sample it was computed from, whose own time it may miss by a hair.
    start = max(position[0][0], voltage[0][0] - 1e-6, *(time[0] for time, _ in pressures))
    end = min(position[0][-1], *(time[-1] for time, _ in pressures))
    inside = position[0][(position[0] >= start) & (position[0] <= end)]
    if len(inside) < 2:
        raise RunError("its topics were not recorded at the same time")
    period = float(np.median(np.diff(inside)))
    if period <= 0.0:
        raise RunError("most of the positions share one time")
    gaps = np.diff(inside)
    if gaps.max() > LONGEST_GAP * period:
        raise RunError(
            f"no position for {gaps.max():.3f} s after {inside[np.argmax(gaps)]:.3f} s, "
            f"which come every {period:.4f} s otherwise"
        )
    time = inside[0] + period * np.arange(round((inside[-1] - inside[0]) / period) + 1)
    last = np.searchsorted(voltage[0], time + 1e-6, side="right") - 1
    pressure_a, pressure_b, supply = (np.interp(time, *pressure) for pressure in pressures)
    return MeasuredRun(
        time=time,
        position=np.interp(time, *position),
        pressure_a=pressure_a,
        pressure_b=pressure_b,
        supply_pressure=supply,
        voltage=voltage[1][np.maximum(last, 0)],
    )
