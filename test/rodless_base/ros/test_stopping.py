# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Ctrl-C and SIGTERM end a node cleanly, whenever they come and however often."""

import contextlib
import itertools
import os
import signal
import sys
import time
from pathlib import Path

import pytest
from extent import some_of
from running import StartProcess, until_it_says
from std_srvs.srv import SetBool
from unmeasured import NOT_MEASURED

from rodless_base.parameter_file import preset_file
from rodless_base.ros.profiles import PROFILE_VARIABLES
from rodless_base.ros.shared_memory import RANGE
from rodless_lab.session.node_process import NodeProcess
from rodless_lab.session.observer import Observer
from rodless_lab.session.processes import node_command

# The product's promise: from the signal to the end of the process, in wall-clock seconds.
STOP_SECONDS = 2.0

# For a start without anything compiled on a crowded machine, in wall-clock s.
COMPILE_SECONDS = 600.0

SIGNALS = pytest.mark.parametrize(
    ("signals", "again"),
    [
        pytest.param([signal.SIGINT], False, id="SIGINT"),
        pytest.param([signal.SIGTERM], False, id="SIGTERM"),
        pytest.param([signal.SIGINT, signal.SIGTERM], True, id="both-until-it-ends"),
    ],
)

# Distinct names, so that no node is taken for the one before it.
NAMESPACES = (f"run{number}" for number in itertools.count())


def ends_cleanly(processes: list[NodeProcess], signals: list[int], again: bool) -> None:
    """Send ``signals`` to all, over and over if ``again``, and check how they end."""
    start = time.monotonic()
    for number in signals:
        for process in processes:
            process.signal(number)
    while again and any(process.exit_code is None for process in processes):
        assert time.monotonic() - start < STOP_SECONDS
        for number, process in itertools.product(signals, processes):
            process.signal(number)
    for process in processes:
        assert process.wait(STOP_SECONDS) == 0, process.output
        for word in ("Traceback", "Exception", "Error"):
            assert word not in process.output


@SIGNALS
def test_a_node_that_is_still_being_imported_ends_at_once(
    start_process: StartProcess, tmp_path: Path, signals: list[int], again: bool
) -> None:
    """A module whose import takes long ends with 0, though it lets no exception out.

    Compiled modules behave so: what a signal handler raises inside their import is lost, or
    comes out as an ImportError.
    """
    (tmp_path / "slow.py").write_text(
        "import signal\n"
        "print('importing', flush=True)\n"
        "while True:\n"
        "    try:\n"
        "        signal.pause()\n"
        "    except BaseException:\n"
        "        pass\n"
    )
    path = {"PYTHONPATH": f"{Path.cwd()}{os.pathsep}{tmp_path}"}
    command = [sys.executable, "-m", "rodless_base.start", "slow"]
    with start_process(command, environment=path) as slow:
        until_it_says(slow, "importing")
        ends_cleanly([slow], signals, again)


@SIGNALS
def test_nodes_that_are_still_compiling_end_at_once(
    start_node: StartProcess, signals: list[int], again: bool
) -> None:
    """A signal between the first line a node prints and its first sample ends it with 0."""
    name = next(NAMESPACES)
    with start_node("plant", namespace=name) as plant:
        until_it_says(plant, "loading")
        ends_cleanly([plant], signals, again)
    with start_node("controller", namespace=name) as controller:
        until_it_says(controller, "loading")
        ends_cleanly([controller], signals, again)


@pytest.fixture(scope="module")
def own_cache(
    start_process: StartProcess, tmp_path_factory: pytest.TempPathFactory
) -> dict[str, str]:
    """Return where compiled code is kept that has the paper's equations and no others."""
    environment = {"XDG_CACHE_HOME": str(tmp_path_factory.mktemp("cache")), **NOT_MEASURED}
    for executable in ("plant", "rig"):
        command = node_command(executable, [], next(NAMESPACES))
        with start_process(command, executable, environment) as process:
            until_it_says(process, "ready: ", COMPILE_SECONDS)
    return environment


def children(process: NodeProcess) -> list[Path]:
    """Return where /proc has the processes that ``process`` has started."""
    tasks = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text(encoding="ascii")
    return [Path("/proc", child) for child in tasks.split()]


@SIGNALS
@pytest.mark.parametrize("executable", ["plant", "rig"])
def test_a_plant_whose_equations_are_compiled_ends_at_once(
    start_process: StartProcess,
    own_cache: dict[str, str],
    executable: str,
    signals: list[int],
    again: bool,
) -> None:
    """Its node is there already, and its parameters take a minute; so ends who compiles for it."""
    command = node_command(executable, [preset_file("calibrated")], next(NAMESPACES))
    with start_process(command, executable, own_cache) as process:
        until_it_says(process, "plant]: compiling, which takes about a minute")
        while not (compiling := children(process)):
            assert process.exit_code is None
            assert "ready" not in process.output
        ends_cleanly([process], signals, again)
        assert "ready" not in process.output
    assert not any(child.exists() for child in compiling)


@SIGNALS
def test_running_nodes_end_in_time(
    observer: Observer, start_node: StartProcess, signals: list[int], again: bool
) -> None:
    """Both nodes, at work with each other, end with 0 and without a word."""
    name = next(NAMESPACES)
    with (
        start_node("plant", namespace=name) as plant,
        start_node("controller", namespace=name) as controller,
    ):
        assert observer.call(SetBool, f"/{name}/plant/pause", data=False).success
        assert observer.call(SetBool, f"/{name}/controller/enable", data=True).success
        ends_cleanly([plant, controller], signals, again)


def options(values: dict[str, str]) -> list[str]:
    """Return parameters as on a command line."""
    return [word for name, value in values.items() for word in ("-p", f"{name}:={value}")]


@pytest.mark.parametrize("reach", some_of(["LOCALHOST", "SUBNET"], 2))
@pytest.mark.parametrize("mode", ["realtime", "lockstep"])
def test_nodes_whose_readers_have_everything_end_without_a_word(
    start_process: StartProcess, domain: dict[str, str], reach: str, mode: str
) -> None:
    """As `ros2 run` starts them, without a profile of DDS: who stays has read all there is."""
    environment = {**domain, **dict.fromkeys(PROFILE_VARIABLES.values(), ""), RANGE: reach}
    own = {"plant": {"time.mode": mode}, "controller": {"reference.type": "sine"}}
    nodes = {node: [*node_command(node), *options(values)] for node, values in own.items()}
    for first in nodes:
        with contextlib.ExitStack() as stack:
            running = {
                node: stack.enter_context(start_process(command, node, environment=environment))
                for node, command in nodes.items()
            }
            for process in running.values():
                until_it_says(process, "ready", COMPILE_SECONDS)
            running[first].signal(signal.SIGINT)
            assert running[first].wait(STOP_SECONDS) == 0
            assert "confirmed" not in running[first].output
