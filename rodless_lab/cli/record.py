"""`rodless record` and `ros2 run rodless_sim recorder`: topics into a rosbag2 bag (MCAP)."""

import argparse
import sys
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path

from rclpy.exceptions import InvalidTopicNameException
from rclpy.utilities import remove_ros_args
from rclpy.validate_topic_name import validate_topic_name

from rodless_base.ros.process import run_node
from rodless_base.start import Stop
from rodless_lab.bags.metadata import BagError
from rodless_lab.bags.ros.recorder import Recorder
from rodless_lab.bags.writer import BagWriter


def main(arguments: Sequence[str], stop: Stop) -> int:
    """Record until ``stop``; return 2 for a bag that cannot be begun, 1 for one not whole."""
    options = _parser().parse_args(remove_ros_args(["record", *arguments])[1:])
    # From here on there is a bag to close, whenever the request to stop comes.
    stop.from_now_on_wait()
    try:
        writer = BagWriter(options.output)
    except BagError as error:
        print(error, file=sys.stderr)
        return 2
    try:
        return record(writer, options.topics, options.wall_time, stop)
    except BagError as error:
        print(error, file=sys.stderr)
        return 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="rodless record",
        description="Record topics into a rosbag2 bag (MCAP) until Ctrl-C.",
        epilog="Times in the bag are plant time where a plant publishes /clock.",
    )
    parser.add_argument(
        "topics", nargs="*", type=_topic_name, help="topics to record (default: all)"
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        default=Path(f"rosbag2_{datetime.now():%Y_%m_%d-%H_%M_%S}"),
        help="folder to create (default: named after the time, as ros2 bag record does)",
    )
    parser.add_argument(
        "--wall-time", action="store_true", help="date messages by the wall clock even so"
    )
    return parser


def _topic_name(text: str) -> str:
    try:
        validate_topic_name(text)
    except InvalidTopicNameException as error:
        raise argparse.ArgumentTypeError(f"{text!r} is no topic name: {error}") from error
    return text


def record(writer: BagWriter, topics: Sequence[str], wall_time: bool, stop: Stop) -> int:
    """Record ``topics`` with ``writer`` and close it; raises :class:`BagError`."""

    def end() -> None:
        stop.requested = True

    recorders: list[Recorder] = []

    def make() -> Recorder:
        recorder = Recorder(
            writer,
            topics,
            wall_time=wall_time,
            on_topics=lambda new: print(f"recording {', '.join(new)}", flush=True),
            on_failure=end,
        )
        recorders.append(recorder)
        return recorder

    with writer:
        code = run_node(make, stop)
    for recorder in recorders:
        _report(writer, recorder)
    if writer.failure is not None:
        raise writer.failure
    return code


def _report(writer: BagWriter, recorder: Recorder) -> None:
    print(f"{sum(writer.counts.values())} messages in {writer.path}")
    for topic in recorder.missing:
        print(f"{topic}: nobody published it", file=sys.stderr)
    for topic, count in recorder.lost.items():
        print(f"{topic}: {count} messages lost on the way", file=sys.stderr)
