"""Record topics until told to stop, as a process of its own."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from rclpy.exceptions import InvalidTopicNameException
from rclpy.validate_topic_name import validate_topic_name

from rodless_base.ros.process import run_node
from rodless_base.start import Stop
from rodless_lab.bags.ros.recorder import Recorder
from rodless_lab.bags.writer import BagWriter


@dataclass(frozen=True)
class RecordResult:
    """How a recording has ended."""

    exit_code: int
    missing: list[str]  # wanted topics that nobody published
    lost: dict[str, int]  # messages that did not arrive, by topic


def check_topic_name(text: str) -> str:
    """Return ``text``; raises ValueError where it is no topic name."""
    try:
        validate_topic_name(text)
    except InvalidTopicNameException as error:
        raise ValueError(f"{text!r} is no topic name: {error}") from error
    return text


def record(
    writer: BagWriter,
    topics: Sequence[str],
    wall_time: bool,
    stop: Stop,
    on_topics: Callable[[list[str]], None],
) -> RecordResult:
    """Record ``topics`` with ``writer`` until ``stop``, and close it.

    ``on_topics`` is told what is being recorded. ``writer.failure`` says whether the bag is whole.
    """
    recorders: list[Recorder] = []

    def end() -> None:
        stop.requested = True

    def make() -> Recorder:
        recorders.append(
            Recorder(writer, topics, wall_time=wall_time, on_topics=on_topics, on_failure=end)
        )
        return recorders[0]

    with writer:
        code = run_node(make, stop)
    if not recorders:
        return RecordResult(code, [], {})
    return RecordResult(code, recorders[0].missing, dict(recorders[0].lost))
