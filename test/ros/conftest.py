"""Fixtures of the ROS tests: a domain of one's own, an observer in it, nodes as processes."""

import os
import signal
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import pytest

# No test folder is on sys.path by itself; this one holds what its tests share.
sys.path.insert(0, str(Path(__file__).parent))

from node_process import OUTPUTS, NodeProcess, StartNode, StartRig
from observer import Observer

from rodless_lab.session.domain import own_domain
from rodless_lab.session.processes import RigProcesses, node_command, write_parameters


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Iterator[None]:
    """Show with a failing test what the processes of its module have printed."""
    report = yield
    if report.failed:
        report.sections += [(f"output of {name}", read()) for name, read in OUTPUTS.items()]
    return report


@pytest.fixture(scope="module")
def domain() -> Iterator[dict[str, str]]:
    """Environment of a DDS domain that this module has for itself, on loopback.

    Without shared memory: what a killed process leaves there stops those after it for good.
    """
    with own_domain() as own, pytest.MonkeyPatch.context() as patch:
        environment = {**own, "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4"}
        for name, value in environment.items():
            patch.setenv(name, value)
        yield environment


@pytest.fixture(scope="module")
def observer(domain: dict[str, str]) -> Iterator[Observer]:
    """Return a node of the module's own, in the root namespace."""
    observer = Observer(domain)
    yield observer
    observer.close()


@pytest.fixture(scope="module")
def rodless(domain: dict[str, str]) -> Callable[..., NodeProcess]:
    """Return a function that makes a process of `rodless` with arguments, as on a command line."""
    start = [sys.executable, "-c", "from rodless_lab.cli.main import main; main()"]
    return lambda *arguments: NodeProcess([*start, *arguments], {**os.environ, **domain})


@pytest.fixture(scope="module")
def start_node(domain: dict[str, str], tmp_path_factory: pytest.TempPathFactory) -> StartNode:
    """Return a context manager that runs ``plant`` or ``controller`` and ends it as Ctrl-C does."""

    @contextmanager
    def running(
        node: str, parameters: Mapping[str, object] | None = None, namespace: str = ""
    ) -> Iterator[NodeProcess]:
        folder = tmp_path_factory.mktemp(node)
        files = [write_parameters(folder / "parameters.yaml", {node: parameters or {}})]
        command = node_command(node, files if parameters else [], namespace)
        with NodeProcess(command, {**os.environ, **domain}) as process:
            yield process
            process.signal(signal.SIGINT)
            assert process.end() == 0
            assert "Traceback" not in process.output

    return running


@pytest.fixture(scope="module")
def start_rig(domain: dict[str, str], tmp_path_factory: pytest.TempPathFactory) -> StartRig:
    """Return a context manager that runs plant and controller and checks that both end well."""

    @contextmanager
    def running(**options: object) -> Iterator[RigProcesses]:
        path = tmp_path_factory.mktemp("rig") / "output"
        name = f"rig {options}"
        with path.open("w", encoding="utf-8") as output:
            OUTPUTS[name] = path.read_text
            try:
                with RigProcesses(environment=domain, output=output, **options) as rig:
                    yield rig
                    rig.check()
                    assert rig.stop() == {"plant": 0, "controller": 0}
                    assert "Traceback" not in path.read_text()
            finally:
                del OUTPUTS[name]

    return running
