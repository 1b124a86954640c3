"""Start plant and controller as processes of their own, and stop them, without `ros2 launch`."""

import contextlib
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Mapping
from pathlib import Path
from types import TracebackType
from typing import IO

import yaml

from rodless_base.parameter_file import preset_file

# What Ctrl-C promises; after it a process is killed.
STOP_SECONDS = 2.0

MODULES = {
    "plant": "rodless_sim.node.plant_node",
    "controller": "rodless_control.node.controller_node",
    "rig": "rodless_lab.session.one_process",
}


def node_command(
    process: str, parameter_files: Iterable[str | Path] = (), namespace: str = ""
) -> list[str]:
    """Return the command line of ``plant``, ``controller``, or ``rig`` (both in one process).

    Later parameter files win.
    """
    command = [sys.executable, "-m", "rodless_base.start", MODULES[process], "--ros-args"]
    for path in parameter_files:
        command += ["--params-file", str(path)]
    if namespace:
        command += ["-r", f"__ns:=/{namespace.strip('/')}"]
    return command


def write_parameters(path: Path, parameters: Mapping[str, Mapping[str, object]]) -> Path:
    """Write parameters by node as a ROS parameter file at ``path`` and return that.

    It holds in every namespace; `-p plant:name:=value` on a command line does not.
    """
    sections = {
        f"/**/{node}": {"ros__parameters": dict(values)}
        for node, values in parameters.items()
        if values
    }
    path.write_text(yaml.safe_dump(sections), encoding="utf-8")
    return path


class RigProcesses:
    """Plant and controller, running between ``__enter__`` and ``__exit__``.

    Each is a process of its own, or with ``one_process`` both are one. The controller takes its
    time from the plant, so that a paused plant is not taken for lost.
    """

    def __init__(
        self,
        preset: str = "paper",
        plant: Mapping[str, object] | None = None,
        controller: Mapping[str, object] | None = None,
        namespace: str = "",
        environment: Mapping[str, str] | None = None,
        output: IO[str] | None = None,
        parameter_file: Path | None = None,
        one_process: bool = False,
        without_controller: bool = False,
    ) -> None:
        """Prepare both with ``preset`` and parameters on top; raises FileNotFoundError.

        Those of ``parameter_file`` are between the two. ``without_controller`` leaves the plant to
        a controller from elsewhere. ``environment`` is added to this process's; ``output`` takes
        what the nodes print (default: where this process prints).
        """
        self._files = [preset_file(preset), *([parameter_file] if parameter_file else [])]
        self._parameters = {
            "plant": plant or {},
            "controller": {"use_sim_time": True, **(controller or {})},
        }
        self._namespace = namespace
        both = ["rig"] if one_process else ["plant", "controller"]
        self._processes = ["plant"] if without_controller else both
        self._environment = {**os.environ, **(environment or {})}
        self._output = output
        self._folder = tempfile.TemporaryDirectory(prefix="rodless_")
        self._running: dict[str, subprocess.Popen[str]] = {}

    def __enter__(self) -> "RigProcesses":
        parameters = write_parameters(Path(self._folder.name, "rig.yaml"), self._parameters)
        with contextlib.ExitStack() as started:
            started.callback(self._folder.cleanup)
            started.callback(self.stop)
            for process in self._processes:
                self._running[process] = subprocess.Popen(
                    node_command(process, [*self._files, parameters], self._namespace),
                    env=self._environment,
                    stdout=self._output,
                    stderr=self._output and subprocess.STDOUT,
                    text=True,
                )
            started.pop_all()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.stop()
        self._folder.cleanup()

    @property
    def pids(self) -> dict[str, int]:
        """Process IDs by process."""
        return {name: process.pid for name, process in self._running.items()}

    def check(self) -> None:
        """Raise RuntimeError if a process has ended by itself."""
        for name, process in self._running.items():
            if process.poll() is not None:
                raise RuntimeError(f"the {name} has ended with exit code {process.returncode}")

    def stop(self) -> dict[str, int]:
        """Interrupt both as Ctrl-C does, kill what does not end in time; return exit codes."""
        for process in self._running.values():
            with contextlib.suppress(ProcessLookupError):
                process.send_signal(signal.SIGINT)
        deadline = time.monotonic() + STOP_SECONDS
        return {name: _ended(process, deadline) for name, process in self._running.items()}


def _ended(process: subprocess.Popen[str], deadline: float) -> int:
    try:
        return process.wait(max(deadline - time.monotonic(), 0.0))
    except subprocess.TimeoutExpired:
        process.kill()
        return process.wait()
