"""All processes of one session."""

import contextlib
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from rodless_base.ros.topics import VALVE_VOLTAGE
from rodless_lab.session.errors import HarnessError, NodeDiedError
from rodless_lab.session.node_process import Guard, NodeProcess
from rodless_lab.session.processes import node_command, write_parameters

# Lines of a node's output that an error shows.
SHOWN_LINES = 30


# Where a controller publishes whose commands pass through the test.
WANTED_VOLTAGE = "valve/wanted_voltage"


@dataclass(frozen=True)
class ProcessPlan:
    """What a session starts.

    ``controller`` are parameters of the PID node, the command line of another one, or None.
    """

    preset: Path
    plant: Mapping[str, object]
    controller: Mapping[str, object] | Sequence[str] | None
    one_process: bool
    relay_commands: bool

    def command_lines(self, folder: Path) -> dict[str, list[str]]:
        """Return command lines by process name; their parameters are files in ``folder``."""
        pid = self.controller if isinstance(self.controller, Mapping) else None
        given = {"plant": self.plant, **({"controller": pid} if pid is not None else {})}
        files = [self.preset, write_parameters(folder / "parameters.yaml", given)]
        if self.one_process:
            return {"rig": node_command("rig", files) + self._remapping("controller:")}
        commands = {"plant": node_command("plant", files)}
        if pid is not None:
            commands["controller"] = node_command("controller", files) + self._remapping()
        elif self.controller is not None:
            remapping = self._remapping()
            arguments = ["--ros-args", *remapping] if remapping else []
            commands["controller"] = [*self.controller, *arguments]
        return commands

    def _remapping(self, node: str = "") -> list[str]:
        return ["-r", f"{node}{VALVE_VOLTAGE}:={WANTED_VOLTAGE}"] if self.relay_commands else []


class SessionProcesses:
    """Processes by name, started together and ended together."""

    def __init__(
        self,
        commands: Mapping[str, Sequence[str]],
        environment: Mapping[str, str],
        output: Path,
    ) -> None:
        """Prepare all; each prints into a file of its name below ``output``."""
        self._guard = Guard()
        everything = {**os.environ, **environment}
        self._processes = {
            name: NodeProcess(name, command, everything, output / f"{name}.txt", self._guard)
            for name, command in commands.items()
        }

    def start(self) -> None:
        """Start all."""
        for process in self._processes.values():
            process.start()

    @property
    def names(self) -> list[str]:
        """Names of all."""
        return list(self._processes)

    def __getitem__(self, name: str) -> NodeProcess:
        if name not in self._processes:
            raise HarnessError(
                f"no process {name!r} in this session; there is {', '.join(self._processes)}"
            )
        return self._processes[name]

    @property
    def outputs(self) -> dict[str, str]:
        """What each has printed so far."""
        return {name: process.output for name, process in self._processes.items()}

    @property
    def exit_codes(self) -> dict[str, int | None]:
        """Exit codes by name, negative for a signal, None of what runs."""
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
        plant = self._processes.get("plant") or self._processes["rig"]
        if plant.exit_code is not None:
            raise HarnessError(f"no sample will come: the {plant.name} was ended by the test")

    def with_outputs(self, text: str) -> str:
        """Return ``text`` and below it the last lines of each output."""
        parts = [text]
        for name, output in self.outputs.items():
            lines = output.splitlines()[-SHOWN_LINES:]
            parts.append(f"--- output of the {name} ---")
            parts += lines or ["(nothing)"]
        return "\n".join(parts)

    def stop(self) -> None:
        """End all, together, and then their guard."""
        with contextlib.ExitStack() as stack:
            stack.callback(self._guard.close)
            for process in self._processes.values():
                stack.callback(process.end)
            for process in self._processes.values():
                process.ask_to_stop()
