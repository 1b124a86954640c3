# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What the topics carried, thinned out, as a ring of rows that pages are sent."""

import threading
from collections import deque
from collections.abc import Sequence
from typing import NamedTuple

# Columns of a row, by name and unit; the terms of the law follow, each in volts.
COLUMNS = {
    "time": "s",
    "position": "m",
    "velocity": "m/s",
    "pressure_a": "Pa",
    "pressure_b": "Pa",
    "supply_pressure": "Pa",
    "voltage": "V",
    "reference": "m",
    "spool": "V",  # the voltage that would hold the spool where it is
    "piston_position": "m",  # of a piston that is a mass of its own
    "piston_velocity": "m/s",
}

# A row is a number for each column, None where none has come.
Row = tuple[float | None, ...]

_PLACES = {name: place for place, name in enumerate(COLUMNS)}


def value(row: Row, name: str) -> float | None:
    """Return what a row has in a column."""
    return row[_PLACES[name]]


def spool_of(row: Row) -> float | None:
    """Return where the spool is, in V; of a rig that does not say it, where its command is."""
    spool = value(row, "spool")
    return value(row, "voltage") if spool is None else spool


# Rows that are kept, and how far they are apart at least, in s of plant time: more than pages show
# at 40 a second, however slowly plant time goes.
LENGTH = 1100
SPACING = 0.02


class News(NamedTuple):
    """What has come since a page was sent rows last; ``anew``: all that it has is void."""

    anew: bool
    rows: list[Row]
    end: "Mark"


class Mark(NamedTuple):
    """How far a page has the rows: of which run, and how many had come."""

    run: int = -1
    rows: int = 0


class _Numbered(NamedTuple):
    """A row, its number in its run, and its time in s."""

    number: int
    time: float
    row: Row


class History:
    """The last rows of a run; a new run begins where time goes backwards.

    The newest row is always there; the next one takes its place where it is less than ``SPACING``
    after the row before, as pages have it too. One thread adds, any reads.
    """

    def __init__(self, length: int = LENGTH) -> None:
        """Keep the last ``length`` rows."""
        self._rows: deque[_Numbered] = deque(maxlen=length)
        self._run = 0
        self.restarts = 0  # how often time ran backwards: a plant that was reset, or another
        self._count = 0
        self._gone = 0  # the number of the last row that has made room
        self._lock = threading.Lock()

    def add(self, row: Sequence[float | None]) -> bool:
        """Take a row; return whether it is news: a sample that is repeated is none."""
        with self._lock:
            last = self._rows[-1].time if self._rows else None
            now = row[0]
            if now is None or now == last:
                return False
            if last is not None and now < last:
                self.restarts += 1
                self._begin()
            self._count += 1
            self._make_room()
            self._rows.append(_Numbered(self._count, now, tuple(row)))
            return True

    def _make_room(self) -> None:
        rows = self._rows
        if len(rows) > 1 and rows[-1].time - rows[-2].time < SPACING:
            rows.pop()
        elif len(rows) == rows.maxlen:
            self._gone = rows.popleft().number

    def clear(self) -> None:
        """Begin anew."""
        with self._lock:
            self._begin()

    def _begin(self) -> None:
        self._rows.clear()
        self._run += 1
        self._count = self._gone = 0

    @property
    def run(self) -> int:
        """Which run this is."""
        with self._lock:
            return self._run

    @property
    def last(self) -> Row | None:
        """The last row."""
        with self._lock:
            return self._rows[-1].row if self._rows else None

    def since(self, mark: Mark) -> News:
        """Return what is new to whoever has the rows up to ``mark``."""
        with self._lock:
            end = Mark(self._run, self._count)
            anew = mark.run != self._run or mark.rows < self._gone
            had = 0 if anew else mark.rows
            return News(anew, [one.row for one in self._rows if one.number > had], end)
