# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless drive`: give a rig the voltages that an identification needs, one for each sample."""

import sys
from collections.abc import Sequence

from rodless_base.command_line import Parser
from rodless_base.constants import CLOSED_VOLTAGE
from rodless_base.parameters import ParameterError
from rodless_base.start import Stop, split_ros_arguments
from rodless_base.topics import VALVE_VOLTAGE
from rodless_lab.cli.number import real, whole
from rodless_lab.identification.excitation import CREEP, EXCITATIONS, PERIOD, excitation
from rodless_lab.session.errors import HarnessError


def main(arguments: Sequence[str], stop: Stop) -> int:
    """Return 0 once all voltages were given, 1 where it was ended before.

    2 for a bad option, and where somebody else commands the valve.
    """
    options = _parser().parse_args(split_ros_arguments(arguments)[0])
    # Here, so that help works without ROS.
    from rodless_lab.session.domain import domain_to_join  # noqa: PLC0415
    from rodless_lab.session.driver import drive  # noqa: PLC0415

    try:
        domain_to_join()
        voltages = excitation(options.subject, options.closed_voltage, options.creep)
    except (HarnessError, ParameterError) as error:
        print(error, file=sys.stderr)
        return 2
    duration = len(voltages) * PERIOD

    def show(seconds: int) -> None:
        if sys.stdout.isatty():
            print(f"\r{seconds} of {duration:.0f} s", end="", flush=True)

    listeners = "a plant" + (f" and {options.recorders} recorders" if options.recorders else "")
    waiting = f"{duration:.1f} s of voltages on {VALVE_VOLTAGE}, waiting for {listeners}"
    print(waiting, flush=True)
    code, done = drive(voltages, PERIOD, options.closed_voltage, options.recorders, stop, show)
    print("\rall given, valve closed" if done else "\rended before all voltages were given")
    return code or (0 if done else 1)


def _parser() -> Parser:
    parser = Parser(
        prog="rodless drive",
        description="Drive a rig so that `rodless identify` finds something, the carriage starting "
        "near 60 mm.",
        epilog="Nobody else may command the valve: start the rig without its controller; beside "
        "one it is refused, with code 2. Record meanwhile. For a namespace append --ros-args -r "
        "__ns:=/NAME.",
    )
    parser.add_argument("subject", choices=sorted(EXCITATIONS))
    parser.add_argument(
        "--recorders",
        type=whole,
        default=0,
        metavar="N",
        help="recorders to wait for (%(default)d), so that the first command is in their bags",
    )
    parser.add_argument(
        "--closed-voltage",
        type=real,
        default=CLOSED_VOLTAGE,
        metavar="V",
        help="where the valve of the rig is closed (%(default)g)",
    )
    parser.add_argument(
        "--creep",
        type=real,
        metavar="V",
        help=f"for friction: how far from there the carriage creeps ({CREEP:g}); of a valve with "
        "0.4 %% of hysteresis, as the preset calibrated has, 0.29",
    )
    return parser
