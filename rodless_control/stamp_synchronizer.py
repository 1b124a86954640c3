"""Messages of several topics, combined to measurements by their stamp."""

from collections.abc import Iterable

from rodless_base.measurement import Measurement

# Run and stamp (ns): a plant that is reset counts its time from 0 again.
Key = tuple[int, int]


class StampSynchronizer:
    """Measurements of which every one of ``fields`` has come, in whatever order topics arrive.

    Messages of one topic arrive in order. A stamp that runs backwards starts the plant's next run;
    messages of different runs are never combined. When a later sample completes, earlier incomplete
    ones are dropped and counted, in ``incomplete``.
    """

    def __init__(self, fields: Iterable[str], capacity: int) -> None:
        """Wait for ``fields`` of :class:`Measurement`, besides the stamp.

        At most ``capacity`` samples wait for some of their messages: what the queues of the topics
        hold.
        """
        self.incomplete = 0
        self._capacity = capacity
        self._latest = dict.fromkeys(fields, (0, -1))
        self._waiting: dict[Key, dict[str, float]] = {}

    def put(self, field: str, stamp: int, value: float) -> Measurement | None:
        """Take one reading; return the measurement that it completes, if it does."""
        run, last = self._latest[field]
        key = (run + (stamp < last), stamp)
        self._latest[field] = key
        readings = self._waiting.setdefault(key, {})
        readings[field] = value
        if len(readings) == len(self._latest):
            self._drop(other for other in list(self._waiting) if other < key)
            return Measurement(stamp, **self._waiting.pop(key))
        if len(self._waiting) > self._capacity:
            self._start_over_with(field, stamp, value)
        return None

    def _drop(self, keys: Iterable[Key]) -> None:
        for key in keys:
            del self._waiting[key]
            self.incomplete += 1

    def _start_over_with(self, field: str, stamp: int, value: float) -> None:
        """Keep this reading alone: where a topic has missed a reset, its runs are miscounted."""
        key = self._latest[field]
        self._drop(other for other in list(self._waiting) if other != key)
        self._latest = {**dict.fromkeys(self._latest, (0, -1)), field: (0, stamp)}
        self._waiting = {(0, stamp): {field: value}}
