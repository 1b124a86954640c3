# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless get`: show parameters of a running rig, as `rodless set` takes them."""

import argparse
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from rodless_base.command_line import Parser
from rodless_base.start import Stop
from rodless_lab.cli.running_rig import add_namespace, add_timeout, value_text, with_rig

if TYPE_CHECKING:
    from rodless_lab.session.running_rig import RunningRig


def main(arguments: Sequence[str], stop: Stop) -> int:
    """Return 0 once they are shown, 2 where there is no such rig or parameter."""
    options = _parser().parse_args(arguments)
    timeout = options.timeout
    return with_rig(options.namespace, stop, lambda rig: _get(rig, options.names, timeout), timeout)


def _parser() -> Parser:
    parser = Parser(
        prog="rodless get",
        description="Show parameters of a running rig, one NAME=VALUE a line, as rodless set "
        "takes them.",
        epilog="Exit code: 0 shown; 1 Ctrl-C; 2 no such rig, no such parameter or no answer.",
    )
    parser.add_argument(
        "names",
        nargs="*",
        type=_name,
        metavar="NAME",
        help="plant:NAME where both nodes have the name (default: all of both nodes)",
    )
    add_namespace(parser)
    add_timeout(parser, "for the nodes to be found, and for each answer")
    return parser


def _name(text: str) -> str:
    if not text:
        raise argparse.ArgumentTypeError("'' is no parameter's name")
    return text


def _get(rig: "RunningRig", names: Sequence[str], timeout: float) -> int:
    # They import ROS.
    from rodless_lab.session.running_rig import NODES, OTHER_NODE_TIMEOUT  # noqa: PLC0415
    from rodless_lab.session.set_parameters import parameter_values  # noqa: PLC0415

    for name, value in parameter_values(rig, names, timeout).items():
        print(f"{name}={value_text(value)}", flush=True)
    for node in NODES:
        if not names and not rig.is_known(node):
            print(rig.missing(node, min(timeout, OTHER_NODE_TIMEOUT)), file=sys.stderr)
    return 0
