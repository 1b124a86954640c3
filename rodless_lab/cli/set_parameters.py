"""`rodless set`: change parameters of a running rig, all of them or none."""

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING

from rodless_base.start import Stop
from rodless_lab.cli.running_rig import add_namespace, seconds, with_rig

if TYPE_CHECKING:
    from rodless_lab.session.running_rig import RunningRig


def main(arguments: Sequence[str], stop: Stop) -> int:
    """Return 0 once all parameters are changed, 2 where that cannot be."""
    parser = _parser()
    options = parser.parse_args(arguments)
    given = dict(options.changes)
    if len(given) < len(options.changes):
        parser.error("the same parameter is given twice")
    return with_rig(options.namespace, stop, lambda rig: _set(rig, given, options.timeout))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="rodless set",
        description="Change parameters of a running rig. Each parameter goes to the node that "
        "declares it. Each node takes all its changes at once or none; if the second node refuses, "
        "the first gets its old values back after running with the new ones for a few "
        "milliseconds.",
        epilog="Example: rodless set supply.pressure=600000 friction.forward.static=35. "
        "Exit code: 0 all changed; 1 Ctrl-C; 2 no such rig, no such parameter, refused or no "
        "answer: nothing has changed unless the error says so.",
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
    parser.add_argument(
        "--timeout",
        type=seconds,
        default=10.0,
        metavar="S",
        help="for the nodes to be found, and for each answer (default: %(default)g s)",
    )
    return parser


def _change(text: str) -> tuple[str, str]:
    name, separator, value = text.partition("=")
    if not (name and separator and value):
        raise argparse.ArgumentTypeError(f"{text!r} is not NAME=VALUE")
    return name, value


def _set(rig: "RunningRig", given: dict[str, str], timeout: float) -> int:
    from rodless_lab.session.set_parameters import change_parameters  # noqa: PLC0415  imports ROS

    for change in change_parameters(rig, given, timeout):
        print(f"{change.node} {change.name}: {_text(change.old)} → {_text(change.new)}")
    return 0


def _text(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str | int | float):
        return str(value)
    return ",".join(map(str, value)) if hasattr(value, "__iter__") else str(value)
