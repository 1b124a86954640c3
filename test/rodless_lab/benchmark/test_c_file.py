# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The rig in C, which the package's speed is measured against: the same runs, and how quick."""

import shutil
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from rodless_lab.bare_rigs import BARE_RIGS, bare_rig
from rodless_lab.benchmark.c_file import FLAGS, CFile, NoCompilerError, compiler, source
from rodless_lab.benchmark.work import PERIOD, TASKS, Task, Work
from rodless_sim import RigParameters
from rodless_sim.physics.plant import Plant
from rodless_sim.rig import starting_motion
from rodless_sim.trace import run_open_loop

pytestmark = pytest.mark.skipif(
    shutil.which("cc") is None, reason="no C compiler: the C file cannot be compiled here"
)

NANOMETRE = 1e-9
PASCAL = 1e-3


@pytest.fixture(scope="module")
def c_file() -> CFile:
    """Return the C file, compiled once for this module."""
    return CFile()


@pytest.mark.parametrize("rig", BARE_RIGS)
@pytest.mark.parametrize("task", TASKS)
def test_same_closed_loop(c_file: CFile, rig: str, task: str) -> None:
    """Six seconds of step and sine: every sample within 1 nm and 1 mPa of the package's."""
    work = Work(rig, task)
    ours = work.run(1.0)
    rows, commands = c_file.closed_loop(
        work.plant, work.gains, work.references, work.state, PERIOD, 1.0
    )
    assert np.ptp(ours[:, 0]) > 0.03
    assert np.abs(rows[:, 0] - ours[:, 0]).max() < NANOMETRE
    assert np.abs(rows[:, 2:4] - ours[:, 2:4]).max() < PASCAL
    assert np.ptp(commands[:, 0]) > 0.5


class BackAndForth:
    """Three seconds 1 mm beyond reach, in which the integral winds up, then 60 mm back."""

    def sample(self, time: float) -> tuple[float, float]:
        """Return position (m) and velocity (m/s) at ``time`` (s)."""
        return (0.201 if time % 4.0 < 3.0 else 0.14), 0.0


@pytest.mark.parametrize("rig", BARE_RIGS)
def test_same_integral_beyond_its_zone(
    c_file: CFile, rig: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It unwinds on the way back: every sample within 1 nm of the package's."""
    monkeypatch.setitem(TASKS, "back and forth", Task(BackAndForth(), 0.19))
    work = Work(rig, "back and forth")
    ours = work.run(1.0)
    rows, commands = c_file.closed_loop(
        work.plant, work.gains, work.references, work.state, PERIOD, 1.0
    )
    error, integral = commands[:, 1], commands[:, 3]
    beyond = np.abs(error[1:]) > work.gains.integral_zone
    assert np.any(np.diff(np.abs(integral))[beyond] < 0.0)
    assert np.abs(rows[:, 0] - ours[:, 0]).max() < NANOMETRE


@pytest.mark.parametrize("rig", BARE_RIGS)
@pytest.mark.parametrize(
    "changes", [{}, {"end_stop.restitution": 0.9, "friction.capture_velocity": 0.0}]
)
def test_same_events(c_file: CFile, rig: str, changes: dict[str, object]) -> None:
    """Breakaway, stops and both caps: the samples of the package within 1 nm and 1 mPa."""
    parameters = bare_rig(rig).with_values(changes)
    plant = Plant.of(parameters)
    state = starting_motion(plant, parameters, 0.15)
    voltages = np.repeat([10.0, 5.08, 0.0, 5.24, 4.0, 6.0], 800)
    ours = run_open_loop(plant, voltages, state, (), 1_000_000, 1.0, 6)[0]
    rows = c_file.open_loop(plant, voltages, state, PERIOD, 1.0)
    assert ours[:, 0].max() == plant.cylinder.stroke
    assert np.any(ours[1:, 1] == 0.0)
    assert np.abs(rows[:, 0] - ours[:, 0]).max() < NANOMETRE
    assert np.abs(rows[:, 2:4] - ours[:, 2:4]).max() < PASCAL


def test_other_rigs_are_refused(c_file: CFile) -> None:
    """A rig that the C file does not know is refused, not computed as another."""
    work = Work("paper", "step")
    for name, value in (
        ("valve.assembly", "printed"),
        ("cylinder.locked", True),
        ("valve.flow_law", "iso_6358"),
        ("leak.b", 1e-9),
        ("rail.tilt", 0.1),
        ("chambers.thermodynamics", "polytropic"),
        ("valve.dynamics", "second_order"),
        ("tubes.model", "delay"),
        ("supply.ripple_amplitude", 1e3),
        ("supply.droop", 1.2e7),
        ("supply.kind", "compressor"),
        ("friction.dynamics", "lugre"),
        ("coupling.kind", "magnetic"),
        ("friction.drift", 0.01),
    ):
        plant = Plant.of(RigParameters({name: value}))
        with pytest.raises(ValueError, match="the C file knows"):
            c_file.open_loop(plant, np.array([6.0]), work.state, PERIOD, 1.0)


def test_it_compiles_without_a_warning() -> None:
    """All warnings on: the compiler has nothing to say."""
    command = [*compiler(), *FLAGS, "-Wall", "-Wextra", "-fsyntax-only", str(source())]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    assert run.stderr == ""
    assert run.returncode == 0


def test_without_a_compiler_it_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    """The error names the command that is missing."""
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(NoCompilerError, match="no-such-compiler"):
        CFile()


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ("gcc '", r"^CC=gcc ': No closing quotation; set CC to a command$"),
        ("''", r"^no C compiler '': install gcc or set CC$"),
        (
            "sh -c 'echo one >&2; echo two >&2; exit 1'",
            r"^the C compiler refuses rig\.c: one two$",
        ),
    ],
)
def test_a_compiler_that_is_none_is_told_in_one_line(
    monkeypatch: pytest.MonkeyPatch, given: str, says: str
) -> None:
    """The benchmark lists the line and goes on; one of blanks is as one that is not set."""
    monkeypatch.setenv("CC", given)
    with pytest.raises(NoCompilerError, match=says):
        CFile()
    monkeypatch.setenv("CC", " ")
    assert compiler() == ["cc"]


def test_a_compiler_that_does_not_run_is_told_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A file that may be run and is no program."""
    file = tmp_path / "compiler"
    file.write_text("no program", encoding="utf-8")
    file.chmod(0o755)
    monkeypatch.setenv("CC", str(file))
    with pytest.raises(NoCompilerError, match=r"compiler does not run: Exec format error$"):
        CFile()


def processor_seconds(function: Callable[[], object]) -> float:
    """Processor time of one call."""
    start = time.process_time()
    function()
    return time.process_time() - start


@pytest.mark.slow
@pytest.mark.parametrize("rig", BARE_RIGS)
@pytest.mark.parametrize("task", TASKS)
def test_the_compiled_loop_keeps_up_with_c(c_file: CFile, rig: str, task: str) -> None:
    """In processor time the package's closed loop takes at most twice that of the C file.

    They take turns and the best of 30 counts, so that what else runs on the machine hits both. On a
    quiet machine the ratio is 0.95 to 1.15.
    """
    work = Work(rig, task)

    def in_c() -> object:
        return c_file.closed_loop(work.plant, work.gains, work.references, work.state, PERIOD, 1.0)

    def ours() -> object:
        return work.run(1.0)

    ours()
    times = [(processor_seconds(ours), processor_seconds(in_c)) for _ in range(30)]
    best, best_in_c = (min(column) for column in zip(*times, strict=True))
    assert best <= 2.0 * best_in_c
