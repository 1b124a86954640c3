# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What all tests share: marks by what a test needs, a ROS domain, nodes as processes.

ROS is imported in the fixtures only, so that tests without it start at once.
"""

from __future__ import annotations

import itertools
import os
import signal
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from unmeasured import NOT_MEASURED

if TYPE_CHECKING:
    from running import StartProcess, StartRig, StartSession

    from rodless_lab.harness import RigSession
    from rodless_lab.session.node_process import NodeProcess
    from rodless_lab.session.observer import Observer
    from rodless_lab.session.processes import SessionProcesses

# A test that uses one of these has nodes or a DDS domain.
ROS_FIXTURES = {"domain", "rig_session", "compiled"}

# Tests of what a rig is made of. Of other tests the processes are not measured for coverage, which
# takes a node half its time: the same nodes run here.
MEASURED = ("rodless_base", "rodless_sim", "rodless_control", "test_uncompiled.py")

# For processes to end by themselves on a crowded machine, in wall-clock s.
STOP_TIMEOUT = 120.0

# What running processes have printed, by their name, so that a failing test can show it.
_outputs: dict[str, Callable[[], str]] = {}
_numbers = itertools.count()


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Mark the tests that use ROS by their fixtures; a few others say so themselves.

    Where ``make test`` lets failed tests run again, only these may: what else is wrong is wrong.
    Files with slow tests come first, so that at the end no core waits for one of them.
    """
    slow = {item.path for item in items if item.get_closest_marker("slow")}
    items.sort(key=lambda item: item.path not in slow)
    for item in items:
        if ROS_FIXTURES.intersection(getattr(item, "fixturenames", ())):
            item.add_marker(pytest.mark.ros)
        if getattr(config.option, "reruns", None) and not item.get_closest_marker("ros"):
            item.add_marker(pytest.mark.flaky(reruns=0))


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Give a further try of a test new fixtures of the module, which it would have as they are."""
    if isinstance(item, pytest.Function) and getattr(item, "execution_count", 1) > 1:
        for fixtures in item._fixtureinfo.name2fixturedefs.values():
            for fixture in fixtures:
                if fixture.scope == "module":
                    fixture.finish(item._request)


@pytest.fixture(scope="session", autouse=True)
def _compiling_is_announced() -> None:
    """What a process says once that compiles is said before a test looks at what is said."""
    from rodless_base.kernel_cache import announce  # noqa: PLC0415

    announce()


@pytest.fixture(scope="session", autouse=True)
def _compiling_is_not_traced() -> Iterator[None]:
    """Where coverage is measured, keep it from following the compiler: that is a third of its time.

    What coverage then misses of the kernels' making, tests of it call in other ways.
    """
    from numba.core.dispatcher import Dispatcher  # noqa: PLC0415

    compile_traced = Dispatcher.compile

    def untraced(dispatcher: Dispatcher, signature: object) -> object:
        trace = sys.gettrace()
        sys.settrace(None)
        try:
            return compile_traced(dispatcher, signature)
        finally:
            sys.settrace(trace)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Dispatcher, "compile", untraced)
        yield


@pytest.fixture(scope="module", autouse=True)
def _processes_are_measured_or_not(request: pytest.FixtureRequest) -> Iterator[None]:
    """Keep coverage out of what the tests of a module start, but for those of ``MEASURED``."""
    with pytest.MonkeyPatch.context() as patch:
        if request.path.relative_to(Path(__file__).parent).parts[0] not in MEASURED:
            for name, value in NOT_MEASURED.items():
                patch.setenv(name, value)
        yield


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Iterator[None]:
    """Show with a failing test what the processes of its module have printed."""
    report = yield
    if report.failed:
        report.sections += [(f"output of {name}", read()) for name, read in _outputs.items()]
    return report


class FailuresAtOnce:
    """Says why a test failed as soon as it has: what runs all may be ended before its summary."""

    def __init__(self, config: pytest.Config) -> None:
        self._config = config

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Write the end of what went wrong."""
        if report.failed:
            terminal = self._config.get_terminal_writer()
            terminal.line(f"\n{report.nodeid} failed:\n{report.longreprtext[-3000:]}")


def pytest_configure(config: pytest.Config) -> None:
    """Say failures at once where nobody can ask for the rest of the output."""
    if os.environ.get("CI") and not hasattr(config, "workerinput"):
        config.pluginmanager.register(FailuresAtOnce(config))


@contextmanager
def _shown(processes: Mapping[str, NodeProcess]) -> Iterator[None]:
    """Show what these processes print if a test fails inside the block."""
    number = next(_numbers)
    names = {f"{name} ({number})": process for name, process in processes.items()}
    _outputs.update({name: lambda one=one: one.output for name, one in names.items()})
    try:
        yield
    finally:
        for name in names:
            del _outputs[name]


@pytest.fixture
def hears_hangup() -> Iterator[None]:
    """Let processes of a test hear that a terminal closes, also where nohup runs the tests."""
    before = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    yield
    signal.signal(signal.SIGHUP, before)


@pytest.fixture(scope="module")
def domain() -> Iterator[dict[str, str]]:
    """Environment of a process in a DDS domain that this module has for itself, on loopback."""
    from rodless_lab.session.domain import own_domain  # noqa: PLC0415

    with own_domain() as own, pytest.MonkeyPatch.context() as patch:
        for name, value in own.items():
            patch.setenv(name, value)
        yield dict(os.environ)


@pytest.fixture(scope="module")
def observer(domain: dict[str, str]) -> Iterator[Observer]:
    """Return a node of the module's own, in the root namespace."""
    from rodless_lab.session.observer import Observer  # noqa: PLC0415

    with Observer(domain) as observer:
        yield observer


@pytest.fixture(scope="module")
def start_process(domain: dict[str, str], tmp_path_factory: pytest.TempPathFactory) -> StartProcess:
    """Return a context manager that runs a command in the domain, ended as by Ctrl-C."""
    from rodless_lab.session.processes import SessionProcesses  # noqa: PLC0415

    @contextmanager
    def running(
        command: list[str], name: str = "process", environment: Mapping[str, str] | None = None
    ) -> Iterator[NodeProcess]:
        everything = {**domain, **(environment or {})}
        folder = tmp_path_factory.mktemp(name)
        processes = SessionProcesses({name: command}, everything, folder, stop_timeout=STOP_TIMEOUT)
        with _shown({name: processes[name]}), processes:
            yield processes[name]

    return running


@pytest.fixture(scope="module")
def rodless(start_process: StartProcess) -> StartProcess:
    """Return a context manager that runs `rodless` with arguments, as on a command line."""
    start = [sys.executable, "-c", "from rodless_lab.cli.main import main; main()"]
    return lambda *arguments: start_process([*start, *arguments], arguments[0])


@pytest.fixture(scope="module")
def start_node(
    start_process: StartProcess, tmp_path_factory: pytest.TempPathFactory
) -> StartProcess:
    """Return a context manager that runs ``plant`` or ``controller``; it has to end well."""
    from rodless_lab.session.processes import node_command, write_parameters  # noqa: PLC0415

    @contextmanager
    def running(
        node: str, parameters: Mapping[str, object] | None = None, namespace: str = ""
    ) -> Iterator[NodeProcess]:
        path = tmp_path_factory.mktemp(node) / "parameters.yaml"
        files = [write_parameters(path, {node: parameters})] if parameters else []
        with start_process(node_command(node, files, namespace), node) as process:
            yield process
            process.signal(signal.SIGINT)
            assert process.wait() == 0
            assert "Traceback" not in process.output

    return running


@pytest.fixture(scope="module")
def start_rig(domain: dict[str, str], tmp_path_factory: pytest.TempPathFactory) -> StartRig:
    """Return a context manager that runs a ProcessPlan and checks that all of it ends well.

    Its nodes are not measured for coverage, which takes them half their time: ``start_node`` and
    ``rodless`` run the same ones.
    """
    from rodless_lab.session.processes import ProcessPlan, run_rig  # noqa: PLC0415

    @contextmanager
    def running(**options: object) -> Iterator[SessionProcesses]:
        folder = tmp_path_factory.mktemp("rig")
        with (
            run_rig(
                ProcessPlan(**options), {**domain, **NOT_MEASURED}, folder, STOP_TIMEOUT
            ) as processes,
            _shown({name: processes[name] for name in processes.names}),
        ):
            yield processes
            processes.check()
            assert set(processes.stop().values()) == {0}
            assert not any("Traceback" in output for output in processes.outputs.values())

    return running


@pytest.fixture
def rig_session(rig_session: StartSession) -> StartSession:
    """Return the plugin's, whose nodes are not measured for coverage, as those of ``start_rig``."""

    def start(*arguments: Any, **options: Any) -> RigSession:
        options["environment"] = {**NOT_MEASURED, **(options.get("environment") or {})}
        return rig_session(*arguments, **options)

    return start
