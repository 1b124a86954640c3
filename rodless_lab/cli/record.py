# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless record` and `ros2 run rodless_sim recorder`: topics into a rosbag2 bag (MCAP)."""

import argparse
import sys
from collections.abc import Sequence

from rodless_base.command_line import Parser, named_path
from rodless_base.start import Stop, split_ros_arguments
from rodless_lab.bags.default_bag import default_bag
from rodless_lab.session.errors import HarnessError


def main(arguments: Sequence[str], stop: Stop) -> int:
    """Record until ``stop``; return 2 for a bag that cannot be begun, 1 for one not whole."""
    options = _parser().parse_args(split_ros_arguments(arguments)[0])
    # Here, so that help works without ROS.
    from rodless_lab.bags.ros.record import record  # noqa: PLC0415
    from rodless_lab.session.domain import domain_to_join  # noqa: PLC0415

    try:
        domain_to_join()
    except HarnessError as error:
        print(error, file=sys.stderr)
        return 2
    return record(options.output, options.topics, stop, options.wall_time)


def _parser() -> Parser:
    parser = Parser(
        prog="rodless record",
        description="Record topics into a rosbag2 bag (MCAP) until Ctrl-C. The bag's folder is "
        "named with -o.",
        epilog="Times in the bag are plant time where a plant publishes /clock.",
    )
    parser.add_argument(
        "topics", nargs="*", type=_topic_name, help="topics to record (default: all)"
    )
    parser.add_argument(
        "-o",
        "--output",
        type=named_path,
        default=default_bag(),
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
