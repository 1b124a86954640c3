# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Plant and controller as processes, without `ros2 launch`: command lines, start and end."""

import contextlib
import os
import sys
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import yaml

from rodless_base.atomic_write import atomic_write, cannot_be_written
from rodless_base.one_line import shown
from rodless_base.parameter_file import preset_file, read_parameter_file
from rodless_base.topics import RIG_CLOCK, ROS_CLOCK, VALVE_VOLTAGE
from rodless_lab.session.errors import HarnessError, NodeDiedError
from rodless_lab.session.node_process import STOP_TIMEOUT, Guard, NodeProcess
from rodless_lab.session.parameter_value import check_value, without_numpy
from rodless_lab.session.temporary_folder import temporary_folder

MODULES = {
    "plant": "rodless_sim.node.plant_node",
    "controller": "rodless_control.node.controller_node",
    "rig": "rodless_lab.session.one_process",
}

# Where a controller publishes whose commands pass through the test.
WANTED_VOLTAGE = "valve/wanted_voltage"

# Lines of a node's output that an error shows.
SHOWN_LINES = 30


def node_command(
    process: str,
    parameter_files: Iterable[str | Path] = (),
    namespace: str = "",
    arguments: Sequence[str] = (),
) -> list[str]:
    """Return the command line of ``plant``, ``controller``, or ``rig`` (both in one process).

    Later parameter files win; ``arguments`` are the process's own.
    """
    start = [sys.executable, "-m", "rodless_base.start", MODULES[process]]
    command = [*start, *arguments, "--ros-args"]
    for path in parameter_files:
        command += ["--params-file", str(path)]
    return command + _in_namespace(namespace)


def _in_namespace(namespace: str) -> list[str]:
    return ["-r", f"__ns:=/{namespace.strip('/')}"] if namespace else []


def write_parameters(path: Path, parameters: Mapping[str, Mapping[str, object]]) -> Path:
    """Write parameters by node as a ROS parameter file at ``path`` and return that.

    It holds in every namespace; `-p plant:name:=value` on a command line does not. Raises
    HarnessError where it cannot be written.
    """
    sections = {
        f"/**/{node}": {"ros__parameters": without_numpy(values)}
        for node, values in parameters.items()
        if values
    }
    try:
        atomic_write(path, yaml.safe_dump(sections))
    except OSError as error:
        raise HarnessError(cannot_be_written(path, error)) from error
    return path


def _check_values(parameters: Mapping[str, Mapping[str, object]]) -> None:
    """Raise TypeError for a value that no parameter file can hold."""
    for values in parameters.values():
        for name, value in values.items():
            check_value(name, value)


def clock_of_its_own(namespace: str, plant: Mapping[str, object]) -> list[str]:
    """Return what dates a bag by the clock of its own rig, where ``plant`` leaves /clock alone."""
    if not namespace.strip("/") or plant.get("time.publish_clock", True):
        return []
    return ["-r", f"recorder:{ROS_CLOCK}:={RIG_CLOCK}"]


@dataclass(frozen=True)
class ProcessPlan:
    """Which processes a rig consists of.

    ``plant`` are parameters on top of ``preset`` and ``parameter_file``. ``controller`` are those
    of the PID node, or the command line of another controller, or None for no controller. The PID
    does not take a paused plant for lost. With
    ``one_process`` plant and PID share a process, and record themselves into a new bag at
    ``record``, if any. With ``relay_commands`` the controller
    publishes on ``WANTED_VOLTAGE``.

    Raises ValueError for options that contradict each other, TypeError for a value that no
    parameter can have, and FileNotFoundError for a preset that does not exist.
    """

    preset: str = "paper"
    plant: Mapping[str, object] = field(default_factory=dict)
    controller: Mapping[str, object] | Sequence[str] | None = field(default_factory=dict)
    parameter_file: Path | None = None
    namespace: str = ""
    one_process: bool = False
    relay_commands: bool = False
    record: Path | None = None

    def __post_init__(self) -> None:
        preset_file(self.preset)
        _check_values(self._given)
        if self.one_process and not self.runs_controller_node:
            raise ValueError("one_process: only the PID of this package can share the process")
        if self.record is not None and not self.one_process:
            raise ValueError("record: only both nodes in one process record themselves")
        if self.relay_commands and self.controller is None:
            raise ValueError("relay_commands: there is no controller whose commands to relay")

    @property
    def runs_controller_node(self) -> bool:
        """Whether the controller is the PID node of this package."""
        return isinstance(self.controller, Mapping)

    @property
    def own_nodes(self) -> tuple[str, ...]:
        """Names of the nodes of this package, in the namespace of the rig."""
        return ("plant", "controller") if self.runs_controller_node else ("plant",)

    def command_lines(self, folder: Path) -> dict[str, list[str]]:
        """Return command lines by process name; their parameters are written into ``folder``."""
        files = self._parameter_files(folder)
        if self.one_process:
            record = [] if self.record is None else ["--record", str(self.record)]
            command = node_command("rig", files, self.namespace, record)
            return {"rig": command + self._remapping("controller:") + self._clock(files)}
        commands = {"plant": node_command("plant", files, self.namespace)}
        if self.runs_controller_node:
            command = node_command("controller", files, self.namespace)
            commands["controller"] = command + self._remapping()
        elif self.controller is not None:
            remapping = _in_namespace(self.namespace) + self._remapping()
            arguments = ["--ros-args", *remapping] if remapping else []
            commands["controller"] = [*self.controller, *arguments]
        return commands

    @property
    def _given(self) -> dict[str, Mapping[str, object]]:
        """Parameters by node."""
        given = {"plant": self.plant}
        if isinstance(self.controller, Mapping):
            # A controller on plant time does not take a paused plant for lost.
            given["controller"] = {"use_sim_time": True, **self.controller}
        return given

    def _parameter_files(self, folder: Path) -> list[Path]:
        given = self._given
        files = [preset_file(self.preset)]
        if self.parameter_file:
            # Here, because launch files load this module and need no compiler.
            from rodless_lab.session.file_parameters import (  # noqa: PLC0415
                check_together,
                own_parameters,
            )

            values = own_parameters(self.parameter_file, self.namespace)
            check_together(self.parameter_file, files[0], values, given)
            files.append(write_parameters(folder / "of_file.yaml", values))
        if any(given.values()):
            files.append(write_parameters(folder / "parameters.yaml", given))
        return files

    def _clock(self, files: Iterable[Path]) -> list[str]:
        values: dict[str, object] = {}
        for file in files if self.record is not None else ():
            values |= read_parameter_file(file, "plant")
        return clock_of_its_own(self.namespace, values)

    def _remapping(self, node: str = "") -> list[str]:
        return ["-r", f"{node}{VALVE_VOLTAGE}:={WANTED_VOLTAGE}"] if self.relay_commands else []


class SessionProcesses:
    """Processes by name, running between ``__enter__`` and ``__exit__``."""

    def __init__(
        self,
        commands: Mapping[str, Sequence[str]],
        environment: Mapping[str, str] | None = None,
        output: Path | None = None,
        stop_timeout: float = STOP_TIMEOUT,
    ) -> None:
        """Prepare all; nothing starts yet.

        ``environment`` is added to this process's. Each prints into a file of its name in the
        folder ``output``, or with None where this process prints. What does not end within
        ``stop_timeout`` (wall-clock s) is killed.
        """
        self._guard = Guard()
        self._stop_timeout = stop_timeout
        everything = {**os.environ, **(environment or {})}
        self._processes = {
            name: NodeProcess(
                name, command, everything, output and output / f"{name}.txt", self._guard
            )
            for name, command in commands.items()
        }

    def __enter__(self) -> "SessionProcesses":
        with contextlib.ExitStack() as stack:
            stack.callback(self.stop)
            for process in self._processes.values():
                process.start()
            stack.pop_all()
        return self

    def __exit__(self, *_error: object) -> None:
        self.stop()

    @property
    def names(self) -> list[str]:
        """Names of all."""
        return list(self._processes)

    def __getitem__(self, name: str) -> NodeProcess:
        if not isinstance(name, str) or name not in self._processes:
            raise HarnessError(
                f"no process {shown(name)} in this session; there is {', '.join(self._processes)}"
            )
        return self._processes[name]

    @property
    def pids(self) -> dict[str, int]:
        """Process ID of each."""
        return {name: process.pid for name, process in self._processes.items()}

    @property
    def outputs(self) -> dict[str, str]:
        """What each has printed so far; empty where that is not kept."""
        return {name: process.output for name, process in self._processes.items()}

    @property
    def exit_codes(self) -> dict[str, int | None]:
        """Exit codes by name, negative for a signal, None of what runs or has not been started."""
        return {name: process.exit_code for name, process in self._processes.items()}

    def check(self) -> None:
        """Raise NodeDiedError if one has ended that was not asked to."""
        for name, process in self._processes.items():
            if process.has_died:
                raise NodeDiedError(
                    self.with_outputs(f"the {name} has ended with exit code {process.exit_code}")
                )

    def check_plant(self) -> None:
        """Raise HarnessError if the plant does not run, for then no sample will come."""
        self.check_node("plant", "no sample will come")

    def check_node(self, node: str, lost: str) -> None:
        """Raise HarnessError, which begins with ``lost``, where the test has ended ``node``."""
        self.check()
        process = self._process_of(str(node).lstrip("/"))
        if process is not None and process.exit_code is not None:
            raise HarnessError(f"{lost}: the {process.name} was ended by the test")

    def _process_of(self, node: str) -> NodeProcess | None:
        """Return the process of a node of this rig, which may have another one in it, or None."""
        own = node in ("plant", "controller")
        return self._processes.get(node) or (self._processes.get("rig") if own else None)

    def is_held(self, node: str) -> bool:
        """Whether the test has ended or frozen the process of ``node``."""
        process = self._process_of(node)
        return process is not None and (process.is_frozen or process.exit_code is not None)

    @property
    def held(self) -> str:
        """Say what the test has ended or frozen, to complete the text of a wait; empty for none."""
        said = []
        for name, process in self._processes.items():
            if process.exit_code is not None:
                said.append(f"; the {name} was ended by the test")
            elif process.is_frozen:
                said.append(f"; the {name} was frozen by the test: thaw({name!r}) lets it go on")
        return "".join(said)

    def with_outputs(self, text: str) -> str:
        """Return ``text`` and below it the last lines of each output that is kept."""
        parts = [text]
        for name, process in self._processes.items():
            if process.keeps_output:
                parts.append(f"--- output of the {name} ---")
                parts += process.output.splitlines()[-SHOWN_LINES:] or ["(nothing)"]
        return "\n".join(parts)

    def stop(self) -> dict[str, int | None]:
        """End all, together, and then their guard; return the exit codes."""
        with contextlib.ExitStack() as stack:
            stack.callback(self._guard.close)
            deadline = time.monotonic() + self._stop_timeout
            for process in self._processes.values():
                stack.callback(_end, process, deadline)
            for process in self._processes.values():
                process.ask_to_stop()
        return self.exit_codes


def _end(process: NodeProcess, deadline: float) -> None:
    process.end(max(deadline - time.monotonic(), 0.0))


@contextlib.contextmanager
def run_rig(
    plan: ProcessPlan,
    environment: Mapping[str, str] | None = None,
    output: Path | None = None,
    stop_timeout: float = STOP_TIMEOUT,
) -> Iterator[SessionProcesses]:
    """Run what ``plan`` says inside the block; for the options see :class:`SessionProcesses`."""
    with (
        temporary_folder() as folder,
        SessionProcesses(
            plan.command_lines(Path(folder)), environment, output, stop_timeout
        ) as processes,
    ):
        yield processes
