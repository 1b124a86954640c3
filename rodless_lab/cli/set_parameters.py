# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless set`: change parameters of a running rig, all of them or none."""

import argparse
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from rodless_base.command_line import Parser, once_each
from rodless_base.start import Stop
from rodless_lab.cli.running_rig import (
    add_namespace,
    add_timeout,
    say_compiling,
    value_text,
    with_rig,
)

if TYPE_CHECKING:
    from rodless_lab.session.running_rig import RunningRig


def main(arguments: Sequence[str], stop: Stop) -> int:
    """Return 0 once all parameters are changed, 2 where that cannot be."""
    parser = _parser()
    options = parser.parse_args(arguments)
    given = once_each(parser, options.changes)
    timeout = options.timeout
    return with_rig(options.namespace, stop, lambda rig: _set(rig, given, timeout), timeout)


def _parser() -> Parser:
    parser = Parser(
        prog="rodless set",
        description="Change parameters of a running rig. Each parameter goes to the node that "
        "declares it; another controller.law brings its own. All are checked before any is sent, "
        "and each node takes its own at once or not at all; if the second node refuses for a "
        "reason that only it knows, the first gets its old values back after running with the new "
        "ones for a few milliseconds.",
        epilog="Example: rodless set supply.pressure=600000 friction.forward.static=35. "
        "Exit code: 0 all changed; 1 the control law fails with the new values, or Ctrl-C; 2 no "
        "such rig, no such parameter, refused or no answer: nothing has changed unless the error "
        "says so.",
    )
    parser.add_argument(
        "changes",
        nargs="+",
        type=_change,
        metavar="NAME=VALUE",
        help="in SI units; several numbers with commas between them; plant:NAME where both nodes "
        "have the name",
    )
    add_namespace(parser)
    add_timeout(parser, "for the nodes to be found, and for each answer")
    return parser


def _change(text: str) -> tuple[str, str]:
    name, separator, value = text.partition("=")
    if not (name and separator and value):
        raise argparse.ArgumentTypeError(f"{text!r} is not NAME=VALUE")
    return name, value


def _set(rig: "RunningRig", given: dict[str, str], timeout: float) -> int:
    # They import ROS.
    from rodless_lab.session.running_rig import CONTROLLER  # noqa: PLC0415
    from rodless_lab.session.set_parameters import change_once_ready, failed_law  # noqa: PLC0415

    changes = change_once_ready(rig, given, timeout, say_compiling)
    for change in changes:
        old = "none" if change.old is None else value_text(change.old)
        print(f"{change.node} {change.name}: {old} → {value_text(change.new)}")
    failure = failed_law(rig) if any(change.node == CONTROLLER for change in changes) else None
    if failure is not None:
        print(f"{CONTROLLER}: {failure}; the new values are in force", file=sys.stderr)
        return 1
    return 0
