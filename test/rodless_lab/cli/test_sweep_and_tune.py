# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless sweep` and `rodless tune`: what they print, write and return."""

import os
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import cast

import pytest
from no_room import no_room
from small_study import write_law, write_study

from rodless_base.start import Stop
from rodless_lab.cli import sweep, tune
from rodless_lab.simulation.run_metrics import metrics_of
from rodless_lab.studies import row_run

TASK = """
vary: {cylinder.moving_mass: {from: 0.7, to: 2.0}}
design: {method: sobol, rows: 2}
run: {duration: 0.1}
set: {reference.at: 0.02, controller.kp: 400.0}
tune: {controller.kp: {from: 50.0, to: 1000.0}}
score: {figures: {mean_error: 1.0e-3, air: 1.0e-3}}
search: {generations: 1, population: 5}
"""


class Quiet:
    """Nobody asks to stop, or somebody does at once."""

    def __init__(self, requested: bool = False) -> None:
        self.requested = requested

    def from_now_on_wait(self, impatient: bool = False) -> None:
        """Nothing to do: the test handles no signals."""


def stop(requested: bool = False) -> Stop:
    """Return what stands in for the signals."""
    return cast("Stop", Quiet(requested))


def test_a_sweep_prints_its_table_and_leaves_data_page_and_picture(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Progress goes to stderr; the page holds what was printed."""
    study, out = write_study(tmp_path), tmp_path / "out"
    assert sweep.main([str(study), "-o", str(out)], stop()) == 0
    printed = capsys.readouterr()
    assert "| final error, size, mm | " in printed.out
    assert "20 of 20 rows" in printed.err
    page = (out / "summary.md").read_text(encoding="utf-8")
    assert "20 rows." in page
    assert "rows.png" in page
    names = {file.name for file in out.iterdir()}
    assert {"rows", "rows.png", "rows.pdf", "rows.csv", "study.json", "summary.md"} <= names


def test_an_interrupted_sweep_says_how_to_go_on(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """And the same command does."""
    arguments = [str(write_study(tmp_path)), "-o", str(tmp_path / "out"), "--workers", "1"]
    assert sweep.main(arguments, stop(requested=True)) == 1
    assert "interrupted; the same command goes on in" in capsys.readouterr().err
    assert sweep.main(arguments, stop()) == 0


def test_a_bad_study_is_refused_in_one_line_and_leaves_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Exit code 2."""
    path = tmp_path / "bad.yaml"
    path.write_text("vary: {supply.presure: [6.0e5]}", encoding="utf-8")
    assert sweep.main([str(path), "-o", str(tmp_path / "out")], stop()) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"{path}: vary: supply.presure: no such parameter")
    assert not (tmp_path / "out").exists()


def test_replay_says_whether_a_row_is_the_same(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """0 where it is, of the sweep begun last where none is named; 1 with what differs."""
    monkeypatch.chdir(tmp_path)
    assert sweep.main([str(write_study(tmp_path))], stop()) == 0
    assert sweep.main(["replay", "3"], stop()) == 0
    assert "equal bit for bit" in capsys.readouterr().out
    monkeypatch.setattr(row_run, "metrics_of", lambda *run: metrics_of(*run)._replace(air=1.0))
    assert sweep.main(["replay", "3"], stop()) == 1
    assert "\nair: " in capsys.readouterr().err
    assert sweep.main(["replay", "99"], stop()) == 2


def test_a_replay_without_a_sweep_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """It says what to give."""
    monkeypatch.chdir(tmp_path)
    assert sweep.main(["replay", "0"], stop()) == 2
    assert "no sweep there; give its folder as --output" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("module", "extra", "verb"), [("SALib", "sensitivity", "tune"), ("pyarrow", "data", "sweep")]
)
def test_a_library_that_is_missing_is_named_in_one_line(
    tmp_path: Path, module: str, extra: str, verb: str
) -> None:
    """With the extra that brings it; it is not ROS that is missing. Nothing is read before."""
    path = tmp_path / "task.yaml"
    path.write_text(TASK.replace("sobol", "saltelli"), encoding="utf-8")
    script = (
        f"import sys; sys.modules[{module!r}] = None; sys.argv = ['rodless', *sys.argv[1:]]\n"
        "from rodless_lab.cli.main import main; main()"
    )
    run = subprocess.run(
        [sys.executable, "-c", script, verb, str(path), "-o", str(tmp_path / "out")],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert run.returncode == 2
    assert run.stderr.count("\n") == 1
    assert run.stderr.endswith(f"pip install 'rodless_sim[{extra}]'\n")


@pytest.mark.parametrize("safe", [False, True])
def test_a_law_beside_the_study_is_found(tmp_path: Path, safe: bool) -> None:
    """In the folder where the command is run, unless Python is told to keep it off its path."""
    study = write_study(tmp_path, write_law(tmp_path), rows=2)
    others = {name: text for name, text in os.environ.items() if name != "PYTHONSAFEPATH"}
    run = subprocess.run(
        [Path(sys.executable).with_name("rodless"), "sweep", study, "-o", tmp_path / "out"],
        cwd=tmp_path,
        env={**others, "NOTED": str(tmp_path / "noted")}
        | ({"PYTHONSAFEPATH": "1"} if safe else {}),
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    if safe and sys.version_info >= (3, 11):
        assert run.returncode == 2
        assert "set: controller.law: 'noted_law:Noted' refused" in run.stderr
    else:
        assert run.returncode == 0, run.stderr


def test_tune_writes_a_parameter_file_and_prints_before_and_after(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Exit code 0; a task that cannot be done ends with 2 and one line."""
    path = tmp_path / "task.yaml"
    path.write_text(TASK, encoding="utf-8")
    assert tune.main([str(path), "-o", str(tmp_path / "out")], stop()) == 0
    printed, shown = capsys.readouterr()
    assert "outside" not in shown
    assert "1 of 10 candidates, best score" in shown
    assert "| `controller.kp` | 400 | " in printed
    assert "| others | tuned | " in printed
    assert "controller.kp: " in (tmp_path / "out" / "tuned.yaml").read_text(encoding="utf-8")
    path.write_text(TASK.replace("kp: {", "kx: {"), encoding="utf-8")
    assert tune.main([str(path), "-o", str(tmp_path / "out")], stop()) == 2
    (line,) = capsys.readouterr().err.splitlines()[-1:]
    assert "controller.kx: no such parameter of the law pid" in line


def test_tune_says_where_a_search_does_not_begin_with_the_values_in_force(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A gain outside of its range is named with both; the search begins at the nearer end."""
    path = tmp_path / "task.yaml"
    path.write_text(TASK.replace("controller.kp: 400.0", "controller.kp: 2000.0"), encoding="utf-8")
    assert tune.main([str(path), "-o", str(tmp_path / "out")], stop()) == 0
    line = (
        "controller.kp: 2000 in force is outside of 50 to 1000; the search begins at the nearer end"
    )
    assert capsys.readouterr().err.splitlines()[0] == line


@pytest.mark.parametrize("verb", [sweep, tune])
def test_a_full_disk_is_said_in_one_line(
    verb: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Code 2, what cannot be written and why; no folder is left."""
    file = tmp_path / "small.yaml"
    file.write_text(TASK, encoding="utf-8")
    chosen = write_study(tmp_path) if verb is sweep else file
    out = tmp_path / "out"
    with no_room():
        assert verb.main([str(chosen), "-o", str(out)], stop()) == 2
    said = capsys.readouterr().err.splitlines()[-1]
    assert said.startswith(str(out))
    assert said.endswith(": cannot be written: File too large")
    assert not out.exists()
