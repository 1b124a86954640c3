# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Bags as pages play them: one, or two on one time, with a cursor that all pages share."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
import numpy.typing as npt

from rodless_base.constants import CARRIAGE, PISTON, SPOOL
from rodless_base.topics import JOINT_STATES, REFERENCE, VALVE_STATE
from rodless_lab.bags.metadata import BagError
from rodless_lab.bags.reader import Bag, read_bag
from rodless_lab.runs.bag_remarks import namespaces_with
from rodless_lab.runs.comparison import QUANTITIES, aligned, common_time, differences
from rodless_lab.runs.from_bag import Recording, recording_in
from rodless_lab.runs.joints import messages_of
from rodless_lab.runs.measured_run import MeasuredRun, RunError, Setpoint
from rodless_lab.view.errors import ViewError
from rodless_lab.view.samples import COLUMNS, Row
from rodless_lab.view.valve_flows import spool_voltage

Array = npt.NDArray[np.float64]

# Rows of a bag that a page is sent: more than it has pixels.
MOST_ROWS = 3000

# How many times as fast as plant time a bag may be played.
SPEEDS = (0.1, 0.25, 0.5, 1.0, 2.0, 5.0)


@dataclass(frozen=True)
class Tape:
    """A recorded run; ``columns`` are those of rows, shape (11, n), NaN where nothing was."""

    name: str
    run: MeasuredRun
    setpoint: Setpoint | None
    columns: Array

    @property
    def begin(self) -> float:
        """Time of the first sample in s."""
        return float(self.columns[0, 0])

    @property
    def end(self) -> float:
        """Time of the last sample in s."""
        return float(self.columns[0, -1])

    @property
    def farthest(self) -> float:
        """How far (m) carriage or piston goes; NaN where neither is known."""
        places = [list(COLUMNS).index(name) for name in ("position", "piston_position")]
        return float(np.fmax.reduce(self.columns[places], axis=None))

    def rows(self) -> list[Row]:
        """Return at most ``MOST_ROWS`` rows, evenly spaced."""
        step = -(-self.columns.shape[1] // MOST_ROWS)
        return [_row(column) for column in self.columns[:, ::step].T]

    def row_at(self, when: float) -> Row:
        """Return the last row up to ``when`` (s), or the first."""
        place = int(np.searchsorted(self.columns[0], when, side="right")) - 1
        return _row(self.columns[:, max(place, 0)])


def _row(column: Array) -> Row:
    return tuple(value if np.isfinite(value) else None for value in column.tolist())


def open_tape(path: Path) -> Tape:
    """Read a bag of one rig, in whatever namespace; raises :class:`ViewError`."""
    try:
        return _tape(path)
    except (BagError, RunError) as error:
        text = str(error)
        raise ViewError(text if path.name in text else f"{path.name}: {text}") from error


def _tape(path: Path) -> Tape:
    bag = read_bag(path)
    namespace = rig_namespace(bag)
    found = recording_in(bag, namespace)
    run = found.run
    joints = partial(_of_joint, bag, namespace, found)
    velocity = joints(JOINT_STATES, CARRIAGE, "velocity")
    by_position = np.gradient(run.position, run.time)
    columns = {
        "time": run.time,
        "position": run.position,
        "velocity": np.where(np.isnan(velocity), by_position, velocity),
        "pressure_a": run.pressure_a,
        "pressure_b": run.pressure_b,
        "supply_pressure": run.supply_pressure,
        "voltage": run.voltage,
        "reference": _reference(bag, namespace, found),
        "spool": spool_voltage(joints(VALVE_STATE, SPOOL, "position")),
        "piston_position": joints(JOINT_STATES, PISTON, "position"),
        "piston_velocity": joints(JOINT_STATES, PISTON, "velocity"),
    }
    return Tape(path.name, run, found.setpoint, np.vstack([columns[name] for name in COLUMNS]))


def rig_namespace(bag: Bag) -> str:
    """Return the namespace of the rig in a bag; raises :class:`ViewError` for none or several."""
    found = namespaces_with(bag, JOINT_STATES)
    if len(found) != 1:
        rigs = ", ".join(one or "/" for one in found) or "none"
        raise ViewError(f"{bag.path}: holds {JOINT_STATES} of {rigs}; one rig can be played")
    return found[0]


def _of_joint(
    bag: Bag, namespace: str, found: Recording, topic: str, joint: str, field: str
) -> Array:
    """Return a joint's position, velocity or effort over the run; NaN where none was recorded."""
    name = f"{namespace}/{topic}"
    carried = messages_of(bag[name], joint) if name in bag and len(bag[name]) else None
    if carried is None:
        return np.full(found.run.time.shape, np.nan)
    # Of the sample before: between stuck and slipping there is no velocity in the middle.
    return _held(found.stamps_of(carried.messages), carried.values(field), found.run.time)


def _reference(bag: Bag, namespace: str, found: Recording) -> Array:
    """Reference (m) as recorded, else the set-points; NaN before the first.

    NaN throughout where the bag does not tell when they were sent.
    """
    if found.sent.why_useless:
        return np.full(found.run.time.shape, np.nan)
    topic = f"{namespace}/{REFERENCE}"
    if topic in bag and len(bag[topic]):
        return _held(*found.numbers_of(bag[topic]), found.run.time)
    if found.setpoint is not None and len(found.setpoint.time):
        return _held(found.setpoint.time, found.setpoint.position, found.run.time)
    return np.full(found.run.time.shape, np.nan)


def _held(when: Array, values: Array, time: Array) -> Array:
    """Return the last of ``values`` at each of ``time``, NaN before the first."""
    place = np.searchsorted(when, time + 1e-6, side="right") - 1
    return np.where(place >= 0, values[np.maximum(place, 0)], np.nan)


@dataclass(frozen=True)
class Apart:
    """How far two runs are apart in one quantity, in ``unit``: second minus first."""

    label: str
    unit: str
    largest: float
    rms: float


class Playback:
    """One tape or two, and where on them everybody is."""

    def __init__(self, tapes: Sequence[Tape], clock: Callable[[], float] = time.monotonic) -> None:
        """Play one tape, or two on one time; raises :class:`ViewError` for runs that never meet."""
        self.apart: tuple[Apart, ...] = ()
        first, *others = tapes
        if others:
            first, other, self.apart = _side_by_side(first, others[0])
            others = [other]
        self.tapes = (first, *others)
        self.begin = min(tape.begin for tape in self.tapes)
        self.end = max(tape.end for tape in self.tapes)
        self._clock = clock
        self._speed = 1.0
        self._playing = False
        self._from = self.begin
        self._since = clock()

    @property
    def cursor(self) -> float:
        """Where the tapes are, in s."""
        if not self._playing:
            return self._from
        return min(self._from + self._speed * (self._clock() - self._since), self.end)

    @property
    def notes(self) -> tuple[str, ...]:
        """What to know of the recordings before they are trusted: one line each."""
        return tuple(note for tape in self.tapes for note in tape.run.notes)

    @property
    def playing(self) -> bool:
        """Whether the cursor moves."""
        return self._playing and self.cursor < self.end

    @property
    def speed(self) -> float:
        """Plant s per wall-clock s."""
        return self._speed

    def play(self, playing: bool) -> None:
        """Let the cursor move, from the beginning where it is at the end; or stop it."""
        now = self.cursor
        self._from = self.begin if playing and now >= self.end else now
        self._since = self._clock()
        self._playing = playing

    def seek(self, when: float) -> None:
        """Put the cursor at ``when`` (s), kept within the tapes."""
        self._playing = self.playing  # tapes that had ended do not run on
        self._from = min(max(when, self.begin), self.end)
        self._since = self._clock()

    def set_speed(self, speed: float) -> None:
        """Play at one of ``SPEEDS``; raises :class:`ViewError` for another."""
        if speed not in SPEEDS:
            raise ViewError(f"speed: {speed:g} refused, must be one of {SPEEDS}")
        self._from, self._since = self.cursor, self._clock()
        self._speed = speed


def _side_by_side(first: Tape, second: Tape) -> tuple[Tape, Tape, tuple[Apart, ...]]:
    """Put two tapes on one time, by their set-points, else by their starts; measure them."""
    run, other = aligned((first.run, first.setpoint), (second.run, second.setpoint))
    try:
        found = differences(run, other, common_time(run.time, other.time))
    except RunError as error:
        raise ViewError(f"{first.name} and {second.name}: {error}") from error
    shifted = first.columns.copy()
    shifted[0] += run.time[0] - first.run.time[0]
    apart = tuple(
        Apart(label, unit, found[name].largest * scale, found[name].rms * scale)
        for name, (label, unit, scale) in QUANTITIES.items()
    )
    return replace(first, run=run, columns=shifted), second, apart
