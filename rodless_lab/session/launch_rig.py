# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A session whose processes `launch` starts and ends; loads without launch."""

from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from rodless_lab.session.domain import own_domain
from rodless_lab.session.errors import HarnessError, NodeDiedError
from rodless_lab.session.node_process import NodeProcess
from rodless_lab.session.processes import SessionProcesses
from rodless_lab.session.session import RigSession
from rodless_lab.session.temporary_folder import temporary_folder


class LaunchedRig(RigSession):
    """A session to enter once the :attr:`actions` of a launch description run.

    It has the options and methods of :class:`RigSession` but for what ends or holds processes:
    those are launch's, and so is their output. The domain is taken at once and kept as long as
    the object lives.
    """

    def __init__(self, *arguments: Any, **options: Any) -> None:
        """Prepare a rig; raises as :class:`RigSession` does."""
        super().__init__(*arguments, **options)
        self._domain = ExitStack()
        self._environment = {
            **self._domain.enter_context(own_domain()),
            **self._extra_environment,
        }
        self._folder = temporary_folder()
        self._actions: list[Any] = []
        self._was_entered = False

    @property
    def actions(self) -> list[Any]:
        """Launch actions that run the processes; raises ImportError where launch is missing."""
        from launch.actions import ExecuteProcess  # noqa: PLC0415  part of ROS alone

        if not self._actions:
            self._actions = [
                ExecuteProcess(
                    cmd=command, name=name, additional_env=self._environment, output="both"
                )
                for name, command in self._plan.command_lines(Path(self._folder.name)).items()
            ]
        return self._actions

    def _start(self, stack: ExitStack) -> None:
        """Take over what launch has started; ``stack`` leaves it running.

        Raises HarnessError the second time: the run goes on from where the first has left it.
        """
        del stack
        if self._was_entered:
            raise HarnessError(
                "the run of a LaunchedRig is that of its first with block, and launch has not "
                "started it anew; do all in one block, or launch another LaunchedRig"
            )
        self._was_entered = True
        self._processes = LaunchedProcesses(self.actions)


class LaunchedProcesses(SessionProcesses):
    """Processes that belong to launch: watched, never touched."""

    def __init__(self, actions: Sequence[Any]) -> None:
        """Watch the processes of these launch actions."""
        self._actions = actions
        self._processes = {}

    def __getitem__(self, name: str) -> NodeProcess:
        raise HarnessError(f"the process {name!r} belongs to launch: hold or end it there")

    def check(self) -> None:
        """Raise NodeDiedError if one has ended."""
        for action in self._actions:
            if action.return_code is not None:
                raise NodeDiedError(f"{action.name} has ended with exit code {action.return_code}")
