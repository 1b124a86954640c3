# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless policy`: the SROS2 policy of a running rig."""

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from rodless_base.atomic_write import atomic_write, cannot_be_written
from rodless_base.command_line import Parser, named_path
from rodless_base.start import Stop
from rodless_lab.cli.exit_code import can_be_written
from rodless_lab.cli.overwriting import check_result_file
from rodless_lab.cli.running_rig import NOT_POSSIBLE, add_namespace, with_rig

if TYPE_CHECKING:
    from rodless_lab.session.running_rig import RunningRig

# How long to wait for a node to appear, in wall-clock s.
TIMEOUT = 10.0

# Who is in the graph has shown all it has after this time (wall-clock s).
DISCOVERY = 5.0


def main(arguments: Sequence[str], stop: Stop) -> int:
    """Print or write the policy; return 2 where there is no rig or no room for the file."""
    parser = Parser(
        prog="rodless policy",
        description="Write the SROS2 policy of a running rig: its nodes may do what they do now, "
        "and nothing else.",
        epilog="See docs/security.md.",
    )
    add_namespace(parser)
    parser.add_argument("-o", "--output", type=named_path, help="file to write (default: print it)")
    options = parser.parse_args(arguments)

    def work(rig: "RunningRig") -> int:
        # Here, so that help works without ROS.
        from rodless_lab.session.running_rig import NODES  # noqa: PLC0415
        from rodless_lab.session.security_policy import policy  # noqa: PLC0415

        for node in NODES:
            rig.wait_for_node(node, TIMEOUT)
        rig.check_alone()
        rig.wait_for(lambda: False, DISCOVERY)
        text = policy(rig.observer.node, list(NODES), rig.namespace)
        if options.output is None:
            print(text, end="")
            return 0
        try:
            atomic_write(options.output, text)
        except OSError as error:
            print(cannot_be_written(options.output, error), file=sys.stderr)
            return NOT_POSSIBLE
        return 0

    if options.output is not None and not can_be_written(options.output, check_result_file):
        return NOT_POSSIBLE
    return with_rig(options.namespace, stop, work)
