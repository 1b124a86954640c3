# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless fault`: show, make and clear the faults of a running rig."""

import argparse
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

PREFIX = "fault."


def main(arguments: Sequence[str], stop: Stop) -> int:
    """Return 0 once all is shown or changed, 2 where that cannot be."""
    parser = _parser()
    options = parser.parse_args(arguments)
    faults = once_each(parser, options.changes)
    for fault, value in faults.items():
        if options.clear and value is not None:
            parser.error(f"{fault}={value}: refused, --clear takes names without values")
        if not options.clear and value is None:
            parser.error(f"{fault}: refused, no value; give {fault}=VALUE, or --clear {fault}")
    given = {PREFIX + fault: value for fault, value in faults.items()}
    timeout = options.timeout
    return with_rig(options.namespace, stop, lambda rig: _work(rig, given, options), timeout)


def _parser() -> Parser:
    parser = Parser(
        prog="rodless fault",
        description="Make faults of a running rig, all of them or none. Without arguments: show "
        "every fault there can be, what it does, and which are active. They are parameters of the "
        "plant, fault.NAME, so that rodless set and ros2 param set make them too.",
        epilog="Example: rodless fault valve.offset=0.2 position.sensor=frozen. Exit code: 0 done; "
        "1 Ctrl-C; 2 no such rig, no such fault, refused or no answer: nothing has changed unless "
        "the error says so.",
    )
    parser.add_argument(
        "changes",
        nargs="*",
        type=_change,
        metavar="NAME=VALUE",
        help="in SI units; with --clear names alone",
    )
    parser.add_argument("--clear", action="store_true", help="end these faults; without names all")
    add_namespace(parser)
    add_timeout(parser, "for the plant to be found, and for each answer")
    return parser


def _change(text: str) -> tuple[str, str | None]:
    name, separator, value = text.partition("=")
    if not name or (separator and not value):
        raise argparse.ArgumentTypeError(f"{text!r} is not NAME=VALUE")
    return name.removeprefix(PREFIX), value if separator else None


def _work(rig: "RunningRig", given: dict[str, str | None], options: argparse.Namespace) -> int:
    # They import ROS, and the compiler.
    from rodless_lab.session.set_parameters import (  # noqa: PLC0415
        change_once_ready,
        parameter_values,
    )
    from rodless_sim.faults import cleared  # noqa: PLC0415

    present = parameter_values(rig, list(given or cleared()), options.timeout)
    if not given and not options.clear:
        print("\n".join(_listed(present)))
        return 0
    changes = {name: value for name, value in given.items() if value is not None}
    if options.clear:
        sound = cleared()
        changes = {n: value_text(sound[n]) for n, value in present.items() if value != sound[n]}
    if not changes:
        names = ", ".join(name.removeprefix(PREFIX) for name in given)
        print(f"not active, so nothing to clear: {names}" if names else "no fault is active")
        return 0
    for change in change_once_ready(rig, changes, options.timeout, say_compiling):
        print(f"{change.name}: {value_text(change.old)} → {value_text(change.new)}")
    return 0


def _listed(present: dict[str, object]) -> list[str]:
    """Return a line for each fault, those that are active marked."""
    from rodless_sim.faults import PARAMETERS  # noqa: PLC0415  the compiler

    lines = []
    for name, declared in PARAMETERS.items():
        value = present[name]
        mark = "*" if value != declared.default else " "
        shown = f"{value_text(value)} {declared.unit}".rstrip()
        lines.append(f"{mark} {name.removeprefix(PREFIX):27} {shown:12} {declared.meaning}")
    return [*lines, "* active" if any(line[0] == "*" for line in lines) else "none is active"]
