# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Messages of several topics, combined to measurements by their stamp."""

from collections.abc import Iterable
from dataclasses import dataclass

from rodless_base.measurement import Measurement

# Run and stamp (ns): a plant that is reset counts its time from 0 again.
Key = tuple[int, int]

NONE_YET: Key = (0, -1)


@dataclass
class _Topic:
    """How far a topic has come, and how far it was before its stamps first ran backwards alone."""

    latest: Key = NONE_YET
    before: Key = NONE_YET


class StampSynchronizer:
    """Measurements of which every one of ``fields`` has come, in whatever order topics arrive.

    Messages of one topic arrive in order. A stamp that runs backwards starts the plant's next run,
    unless the topic goes on where it was before any other has followed: then the stamp was wrong.
    Messages of different runs are never combined. When a later sample completes, earlier incomplete
    ones are dropped and counted, in ``incomplete``; not so what comes again of one that has
    completed, as a lock-step plant offers it. Before any has completed, topics may have been heard
    from different runs on: then a stamp that runs backwards begins all of them anew.
    """

    def __init__(self, fields: Iterable[str], capacity: int) -> None:
        """Wait for ``fields`` of :class:`Measurement`, besides the stamp.

        At most ``capacity`` samples wait for some of their messages: what the queues of the topics
        hold.
        """
        self.incomplete = 0
        self._completed = NONE_YET
        self._capacity = capacity
        self._topics = {field: _Topic() for field in fields}
        self._waiting: dict[Key, dict[str, float]] = {}

    def put(self, field: str, stamp: int, value: float) -> Measurement | None:
        """Take one reading; return the measurement that it completes, if it does."""
        if self._completed == NONE_YET and stamp < self._topics[field].latest[1]:
            self._drop(list(self._waiting))
            self._start_over_with(field, stamp, value)
            return None
        key = self._key(field, stamp)
        readings = self._waiting.setdefault(key, {})
        readings[field] = value
        if len(readings) == len(self._topics):
            self._drop(other for other in list(self._waiting) if other < key)
            self._completed = key
            return Measurement(stamp, **self._waiting.pop(key))
        if len(self._waiting) > self._capacity:
            # Where a topic has missed a reset, its runs are miscounted.
            self._drop(other for other in list(self._waiting) if other != key)
            self._start_over_with(field, stamp, value)
        return None

    def _key(self, field: str, stamp: int) -> Key:
        """Return run and stamp of a reading, and take note of how far its topic has come."""
        topic = self._topics[field]
        run, last = topic.latest
        alone = all(run > other.latest[0] for other in self._topics.values() if other is not topic)
        if alone and stamp > topic.before[1]:
            run, _ = topic.before
            self._drop(key for key in list(self._waiting) if key[0] > run)
        elif stamp < last:
            if not alone:
                topic.before = topic.latest
            run += 1
        topic.latest = run, stamp
        return topic.latest

    def _drop(self, keys: Iterable[Key]) -> None:
        for key in keys:
            del self._waiting[key]
            self.incomplete += key != self._completed

    def _start_over_with(self, field: str, stamp: int, value: float) -> None:
        """Keep this reading alone."""
        self._completed = NONE_YET
        self._topics = {other: _Topic() for other in self._topics}
        self._topics[field].latest = (0, stamp)
        self._waiting = {(0, stamp): {field: value}}
