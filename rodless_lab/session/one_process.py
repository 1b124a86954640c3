# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Plant and controller in one process, one executor, for machines where two are too many."""

import argparse
import sys
from functools import partial

from rclpy.parameter import Parameter

from rodless_base.command_line import Parser, named_path
from rodless_base.ros.process import run_nodes
from rodless_base.ros.profiles import leave_out_own_endpoints, settle_transports
from rodless_base.start import Stop, split_ros_arguments
from rodless_base.topics import OPTIONAL_TOPICS, RIG_TOPICS, ROS_CLOCK
from rodless_control.law_calls import LawCalls
from rodless_control.node import controller_node
from rodless_lab.bags.default_bag import default_bag
from rodless_sim.node import plant_node


def main(stop: Stop) -> int:
    """Run both until ``stop``; with ``--record BAG`` record them into a new bag besides."""
    folder = _options().record
    leave_out_own_endpoints()
    settle_transports(sys.argv)
    plant_node.load()
    controller_node.load()
    LawCalls.break_off_once_asked(stop)
    make_plant = partial(plant_node.PlantNode, stop)
    if folder is None:
        return run_nodes([make_plant, controller_node.ControllerNode], stop)
    # Here, so that the nodes run without what bags need.
    from rodless_lab.bags.ros.record import record  # noqa: PLC0415

    # Both wait for the recorder, so that the bag has all from sample 0 on.
    plant, controller = (
        [Parameter(name, value=1)] for name in ("time.recorders", "controller.recorders")
    )
    return record(
        folder,
        [ROS_CLOCK, *RIG_TOPICS],
        stop,
        optional=OPTIONAL_TOPICS,
        beside=[
            partial(make_plant, parameter_overrides=plant),
            partial(controller_node.ControllerNode, parameter_overrides=controller),
        ],
    )


def _options() -> argparse.Namespace:
    parser = Parser(prog="rig", description=__doc__)
    parser.add_argument(
        "--record",
        nargs="?",
        type=named_path,
        const=default_bag(),
        metavar="BAG",
        help="folder of a new bag (without one: named after the time)",
    )
    return parser.parse_args(split_ros_arguments(sys.argv[1:])[0])
