# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless move`: move the carriage of a running rig to a position and measure the move."""

import argparse
import sys
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING

from rodless_base.command_line import Parser
from rodless_base.start import Stop
from rodless_lab.cli.number import millimetres
from rodless_lab.cli.running_rig import add_namespace, add_timeout, with_rig

if TYPE_CHECKING:
    from rodless_lab.session.running_rig import RunningRig
    from rodless_lab.session.track import MoveResult, Track

# How often the position is shown, in s.
SHOW_PERIOD = 0.1


def main(arguments: Sequence[str], stop: Stop) -> int:
    """Return 0 once the carriage has settled, 1 if it has not, 2 if it could not be sent there."""
    parser = _parser()
    options = parser.parse_args(arguments)
    return with_rig(options.namespace, stop, lambda rig: _move(rig, options))


def _parser() -> Parser:
    parser = Parser(
        prog="rodless move",
        description="Move the carriage of a running rig to a position in mm, wait until it has "
        "stayed within 0.2 mm of it for 0.5 s, and print the metrics of the step. Times are plant "
        "time. Ctrl-C ends this program; the rig keeps running.",
        epilog="Exit code: 0 settled; 1 not settled in time, plant time stands still, or Ctrl-C; "
        "2 no such rig, the controller refuses the position, another set-point takes its place, "
        "the plant ends, or the move cannot be measured.",
    )
    parser.add_argument("position", type=millimetres, metavar="MM", help="in mm, such as 58")
    add_namespace(parser)
    add_timeout(parser, "wall-clock time to settle in; finding the nodes has 6 s of its own", 30.0)
    return parser


def _move(rig: "RunningRig", options: argparse.Namespace) -> int:
    from rodless_lab.session.move import SetpointMove, StandstillError  # noqa: PLC0415  imports ROS

    move = SetpointMove(rig, options.position / 1e3)
    show = Progress(options.position)
    try:
        move.prepare()
    except StandstillError as error:
        print(f"{error}; no set-point sent", file=sys.stderr)
        return 1
    print(f"from {move.track.position * 1e3:.2f} to {options.position:g} mm", flush=True)
    result = move.make(options.timeout, show, lambda text: print(f"\n{text}", file=sys.stderr))
    show.end(move.track)
    code = _report(result, options)
    # A move that has settled was measured beside another node's commands, too.
    for obstacle in rig.rivals() if result.settled else rig.obstacles():
        print(obstacle, file=sys.stderr)
    return code


def _report(result: "MoveResult", options: argparse.Namespace) -> int:
    from rodless_lab.runs.step_metrics import metric_lines  # noqa: PLC0415  imports numpy

    if result.metrics is None:
        print("the carriage was there already")
    else:
        print("\n".join(metric_lines(result.metrics)))
    if result.from_sending is not None:
        print(f"times count from when the set-point was sent: {result.from_sending}")
    if not result.settled:
        position = result.position * 1e3
        print(
            f"not settled within {options.timeout:g} s: the carriage is at {position:.2f} mm, "
            f"{position - options.position:+.2f} mm from the set-point",
            file=sys.stderr,
        )
        return 1
    return 0


class Progress:
    """Shows where the carriage is: on a terminal a line that is written over, elsewhere nothing."""

    def __init__(self, target: float) -> None:
        """Show positions on the way to ``target`` (mm)."""
        self._target = target
        self._shown = 0.0

    def __call__(self, track: "Track") -> None:
        """Show where the carriage is, unless that was just done."""
        if sys.stdout.isatty() and time.monotonic() > self._shown + SHOW_PERIOD:
            self._shown = time.monotonic()
            print(f"\r{self._line(track)}", end="", flush=True)

    def end(self, track: "Track") -> None:
        """Show the last position and end the line."""
        if sys.stdout.isatty():
            print(f"\r{self._line(track)}")

    def _line(self, track: "Track") -> str:
        return f"{track.elapsed:7.2f} s   {track.position * 1e3:8.3f} mm of {self._target:g} mm"
