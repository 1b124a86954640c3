"""`rodless record` and `ros2 run rodless_sim recorder`: topics into a rosbag2 bag (MCAP)."""

import argparse
import sys
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path

from rodless_base.start import Stop, split_ros_arguments
from rodless_lab.bags.metadata import BagError


def main(arguments: Sequence[str], stop: Stop) -> int:
    """Record until ``stop``; return 2 for a bag that cannot be begun, 1 for one not whole."""
    options = _parser().parse_args(split_ros_arguments(arguments)[0])
    # Here, so that help works without ROS.
    from rodless_lab.bags.ros.record import record  # noqa: PLC0415
    from rodless_lab.bags.writer import BagWriter  # noqa: PLC0415

    # From here on there is a bag to close, whenever the request to stop comes.
    stop.from_now_on_wait()
    try:
        writer = BagWriter(options.output)
    except BagError as error:
        print(error, file=sys.stderr)
        return 2
    result = record(writer, options.topics, options.wall_time, stop, _tell_topics)
    print(f"{sum(writer.counts.values())} messages in {writer.path}")
    for topic in result.missing:
        print(f"{topic}: nobody published it", file=sys.stderr)
    for topic, count in result.lost.items():
        print(f"{topic}: {count} messages lost on the way", file=sys.stderr)
    if writer.failure is not None:
        print(writer.failure, file=sys.stderr)
        return 1
    return result.exit_code


def _tell_topics(new: list[str]) -> None:
    print(f"recording {', '.join(new)}", flush=True)


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
    from rodless_lab.bags.ros.record import check_topic_name  # noqa: PLC0415

    try:
        return check_topic_name(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from error
