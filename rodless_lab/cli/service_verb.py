# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Verbs that ask the nodes of a running rig for one thing each."""

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rodless_base.command_line import Parser
from rodless_base.start import Stop
from rodless_lab.cli.running_rig import add_namespace, add_timeout, with_rig

if TYPE_CHECKING:
    from rodless_lab.session.running_rig import RunningRig


ENABLE = "controller/enable"


@dataclass(frozen=True)
class ServiceVerb:
    """A verb, what it does in a sentence, and the services it calls.

    ``services`` are named ``node/service``; those of the controller beside some of the plant are
    called only where it is there. True or false is what a service is told that switches something,
    None stands for one that is told nothing.
    """

    name: str
    description: str
    services: Mapping[str, bool | None]

    def __call__(self, arguments: Sequence[str], stop: Stop) -> int:
        """Return 0 once it is done, 1 where the controller's law fails with it, 2 if it cannot."""
        options = self._parser().parse_args(arguments)
        timeout = options.timeout
        return with_rig(options.namespace, stop, lambda rig: self._ask(rig, timeout), timeout)

    def _parser(self) -> Parser:
        parser = Parser(
            prog=f"rodless {self.name}",
            description=self.description,
            epilog="Exit code: 0 done; 1 Ctrl-C, or a law that fails again; 2 no such rig, refused "
            "or no answer.",
        )
        add_namespace(parser)
        add_timeout(parser, "for a node to be found, and for its answer")
        return parser

    def _ask(self, rig: "RunningRig", timeout: float) -> int:
        # They import ROS.
        from rodless_lab.session.running_rig import CONTROLLER  # noqa: PLC0415
        from rodless_lab.session.services import ask_each  # noqa: PLC0415
        from rodless_lab.session.set_parameters import failed_law  # noqa: PLC0415

        for service, answer in ask_each(rig, self.services, timeout):
            print(f"{service}: {answer or 'done'}")
        # With the next sample, which an answer does not wait for.
        failure = failed_law(rig) if self.services.get(ENABLE) else None
        if failure is not None:
            print(f"{CONTROLLER}: {failure}", file=sys.stderr)
        return int(failure is not None)
