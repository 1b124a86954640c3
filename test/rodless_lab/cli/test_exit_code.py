# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Results that cannot be written are said before the work; what is cut short is no success."""

import os
import signal
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest
from quiet_stop import Quiet

from rodless_lab.cli import (
    animate,
    bench,
    campaign,
    compare,
    docs,
    experiment,
    identify,
    laws,
    policy,
    replay,
    soak,
    sweep,
    tune,
)
from rodless_lab.cli.exit_code import exit_code

pytestmark = pytest.mark.usefixtures("hears_hangup")


def never(*_arguments: object) -> None:
    """Stand for the work."""
    raise AssertionError


def test_a_folder_that_cannot_be_written_to_is_said_before_the_work(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Exit code 2 and one line that names the output."""
    (tmp_path / "file").write_text("mine")
    output = tmp_path / "file" / "results"
    assert exit_code(never, output) == 2
    assert capsys.readouterr().err == f"{output}: cannot be written: Not a directory\n"
    assert (tmp_path / "file").read_text() == "mine"


@pytest.mark.parametrize(
    ("verb", "arguments"),
    [
        (replay, "missing --output /proc/results"),
        (compare, "paper missing --output /proc/results"),
        (animate, "missing --output /proc/run.gif"),
        (animate, "paper --output /"),
        (identify, "valve missing --output /proc/found.yaml"),
        (identify, "valve missing --output /"),
        (docs, "/proc/docs"),
        (policy, "--output /proc/policy.xml"),
    ],
)
def test_verbs_that_work_for_long_look_at_their_output_first(
    verb: ModuleType, arguments: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """The bag, which is missing, the run, or the rig, has not been asked for yet."""
    assert verb.main(arguments.split(), Quiet()) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"{arguments.rsplit(maxsplit=1)[-1]}: cannot be written: ")
    assert said.count("\n") == 1


@pytest.mark.parametrize("verb", [bench, soak], ids=["bench", "soak"])
def test_what_takes_an_hour_looks_at_its_output_first(
    verb: ModuleType, capsys: pytest.CaptureFixture[str]
) -> None:
    """Exit code 2 and one line that names the output."""
    assert verb.main(["--output", "/proc/found.md"], Quiet()) == 2
    said = capsys.readouterr().err
    assert said.startswith("/proc/found.md: cannot be written: ")
    assert said.count("\n") == 1


@pytest.mark.parametrize(
    ("verb", "arguments", "work", "file"),
    [
        (tune, "pid --output out", "rodless_lab.studies.tune.search", "out/tuned.yaml"),
        (tune, "pid --output out", "rodless_lab.studies.tune.search", "out/trade_off.csv"),
        (sweep, "friction --output out", "rodless_lab.studies.sweep.run_sweep", "out/summary.md"),
        (sweep, "friction --output out", "rodless_lab.studies.sweep.run_sweep", "out/rows.png"),
        (experiment, "sine --output out", "rodless_lab.cli.experiment.perform", "out/summary.md"),
        (campaign, "--output out/c.csv", "rodless_lab.accuracy.campaign.campaign", "out/c.md"),
        (laws, "--output out", "rodless_lab.benchmark.laws.contest.contest", "out/laws.md"),
        (
            bench,
            "--only solvers --output out/b.json",
            "rodless_lab.benchmark.side_by_side.bench_side_by_side",
            "out/side_by_side.md",
        ),
        (compare, "paper bag --output out", "rodless_lab.cli.compare._compare", "out/compare.json"),
        (replay, "bag --output out", "rodless_lab.cli.replay._replay", "out/replay.png"),
    ],
)
def test_a_folder_in_place_of_a_result_is_said_before_the_work(
    verb: ModuleType,
    arguments: str,
    work: str,
    file: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """One line with the file and why, whichever of the results it is; nothing else is there."""
    monkeypatch.chdir(tmp_path)
    Path(file).mkdir(parents=True)
    monkeypatch.setattr(work, never)
    assert verb.main(arguments.split(), Quiet()) == 2
    said = capsys.readouterr().err.splitlines()[-1]
    assert said.removeprefix(f"{tmp_path}/") == f"{file}: cannot be written: Is a directory"
    assert [str(path) for path in Path("out").rglob("*")] == [file]


def said_by(command: str, **environment: str) -> str:
    """Run a verb by the shell after ``command``; return the line that it says with code 2."""
    run = f'exec {sys.executable} -c "from rodless_lab.cli.main import main; main()"'
    done = subprocess.run(
        ["sh", "-c", f"{command} {run} sweep friction --output out --workers 0"],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 2
    return done.stderr


def test_a_folder_that_is_gone_is_said(tmp_path: Path) -> None:
    """What runs in it can neither read nor write anything there."""
    gone = tmp_path / "gone"
    gone.mkdir()
    said = said_by(f"cd {gone} && rmdir {gone} &&")
    assert (
        "the folder in which this runs: No such file or directory; go into another"
        in said.splitlines()[-1]
    )
    assert "Traceback" not in said


def test_what_shows_pictures_does_not_matter(tmp_path: Path) -> None:
    """Verbs draw into files, whatever matplotlib is told to show them with."""
    said_by(f"cd {tmp_path} &&")  # which says so where it has to compile
    said = said_by(f"cd {tmp_path} &&", MPLBACKEND="nonsense")
    assert said.count("\n") == 1
    assert "workers 0 refused" in said


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_what_is_interrupted_is_no_success(tmp_path: Path, number: int) -> None:
    """A verb that has not done what it is for ends with 1 and says so; its report is not there."""
    run = "from rodless_lab.cli.main import main; main()"
    with subprocess.Popen(
        [sys.executable, "-c", run, "experiment", "friction", "--output", str(tmp_path / "out")],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout is not None
        assert process.stdout.read(len("[1/1] friction")) == "[1/1] friction"
        process.send_signal(number)
        _, said = process.communicate(timeout=60)
    assert (process.returncode, said.splitlines()[-1]) == (1, "interrupted")
    assert not (tmp_path / "out").exists()
