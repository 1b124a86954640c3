# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""No command puts its results in the place of what it reads."""

from collections.abc import Callable
from pathlib import Path

import pytest
from quiet_stop import Quiet

from rodless_lab.cli import animate, bench, compare, laws, replay, soak, sweep, tune
from rodless_lab.cli.overwriting import check_none_is_read

STUDY = """
vary: {cylinder.moving_mass: {from: 0.7, to: 2.0}}
design: {method: sobol, rows: 2}
run: {duration: 0.1}
set: {reference.at: 0.02, controller.kp: 400.0}
"""

TASK = f"""{STUDY}
tune: {{controller.kp: {{from: 50.0, to: 1000.0}}}}
score: {{figures: {{mean_error: 1.0e-3, air: 1.0e-3}}}}
search: {{generations: 1, population: 5}}
"""

GAINS = "/**: {ros__parameters: {controller.kp: 300.0}}\n"
BAG = "rosbag2_bagfile_information: {}\n"


def written(file: Path, content: str) -> Path:
    """Write a file, in a folder that is made for it; return it."""
    file.parent.mkdir(exist_ok=True)
    file.write_text(content, encoding="utf-8")
    return file


def linked(link: Path, target: Path) -> Path:
    """Make a link to a file, in a folder that is made for it; return it."""
    link.parent.mkdir(exist_ok=True)
    link.symlink_to(target)
    return link


def files_in(folder: Path) -> dict[Path, bytes | None]:
    """Return all that is in a folder, and what each file holds."""
    return {one: one.read_bytes() if one.is_file() else None for one in folder.rglob("*")}


def refused(
    main: Callable[..., int],
    arguments: list[object],
    folder: Path,
    capsys: pytest.CaptureFixture[str],
) -> str:
    """Return the last line of a command that ends with 2 and leaves ``folder`` as it was.

    Before it may stand that equations are compiled, as the study is read.
    """
    before = files_in(folder)
    assert main(list(map(str, arguments)), Quiet()) == 2
    assert files_in(folder) == before
    return capsys.readouterr().err.splitlines()[-1]


def cannot(file: Path, what: str) -> str:
    """Return the line that a file cannot be written."""
    return f"{file}: cannot be written: it is read as {what}; give another --output"


def test_tune_does_not_replace_its_task(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """By its name, by a link, and in the folder that it takes where none is given."""
    out = tmp_path / "out"
    task = written(out / "tuned.yaml", TASK)
    assert refused(tune.main, [task, "-o", out], tmp_path, capsys) == cannot(task, "the task")
    named = linked(tmp_path / "task.yaml", task)
    assert refused(tune.main, [named, "-o", out], tmp_path, capsys) == cannot(task, "the task")
    page = linked(tmp_path / "other" / "tuning.md", task)
    line = refused(tune.main, [task, "-o", page.parent], tmp_path, capsys)
    assert line == cannot(page, "the task")
    monkeypatch.chdir(tmp_path)
    default = Path("results/tuning/tuned/tuned.yaml")
    (tmp_path / default).parent.mkdir(parents=True)
    (tmp_path / default).write_text(TASK, encoding="utf-8")
    assert refused(tune.main, [default], tmp_path, capsys) == cannot(default, "the task")


def test_tune_does_not_replace_the_base_of_its_task(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The result of an earlier search, from which another one begins in the same folder."""
    base = written(tmp_path / "out" / "tuned.yaml", GAINS)
    task = written(tmp_path / "out" / "again.yaml", f"base: tuned.yaml\n{TASK}")
    line = refused(tune.main, [task, "-o", tmp_path / "out"], tmp_path, capsys)
    assert line == cannot(base, "the base of the task")


def test_sweep_does_not_replace_its_study_or_the_base(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A study that its page is a link to, and a base that is called as one of its tables."""
    study = written(tmp_path / "study.yaml", STUDY)
    page = linked(tmp_path / "out" / "summary.md", study)
    line = refused(sweep.main, [study, "-o", tmp_path / "out"], tmp_path, capsys)
    assert line == cannot(page, "the study")
    base = written(tmp_path / "rows.csv", GAINS)
    study.write_text(f"base: rows.csv\n{STUDY}", encoding="utf-8")
    line = refused(sweep.main, [study, "-o", tmp_path], tmp_path, capsys)
    assert line == cannot(base, "the base of the study")


def test_laws_do_not_replace_their_parameters(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A parameter file that is called as the table of all runs."""
    file = written(tmp_path / "runs.csv", GAINS)
    arguments = ["--law", "pid", "--law", f"pid={file}", "--rigs", "1", "-o", tmp_path]
    assert refused(laws.main, arguments, tmp_path, capsys) == cannot(file, "parameters of --law")


def test_replay_does_not_replace_its_parameters(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """JSON is YAML: a parameter file may be called as the numbers that are written."""
    file = written(tmp_path / "replay.json", GAINS)
    arguments = ["bag", "--parameters", file, "-o", tmp_path]
    assert refused(replay.main, arguments, tmp_path, capsys) == cannot(file, "--parameters")


@pytest.mark.parametrize("name", ["metadata.yaml", "bag_0.mcap", "bag_0.db3", "bag_0.mcap.zstd"])
def test_no_result_goes_through_a_link_into_a_bag(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    """Pictures and numbers are written where a link leads; a file of a bag is not there for it."""
    bag = written(tmp_path / "bag" / name, BAG).parent
    for main, link, output in (
        (compare.main, "compare.json", tmp_path),
        (replay.main, "replay.png", tmp_path),
        (animate.main, "film.gif", tmp_path / "film.gif"),
    ):
        file = linked(tmp_path / link, bag / name)
        run = ["paper", bag] if main is compare.main else [bag]
        line = refused(main, [*run, "-o", output], tmp_path, capsys)
        assert line == (
            f"{file}: cannot be written: it has the name of a file of a bag; give another --output"
        )


def test_other_files_are_written(tmp_path: Path) -> None:
    """Beside what is read, over an earlier result, and where nothing of either is yet."""
    read = written(tmp_path / "task.yaml", TASK)
    earlier = written(tmp_path / "tuned.yaml", GAINS)
    check_none_is_read([earlier, tmp_path / "new.yaml"], {read: "the task"})
    check_none_is_read([tmp_path / "new.yaml"], {tmp_path / "new.yaml": "--base"})


@pytest.mark.parametrize(("verb", "name"), [(soak, "bag_0.mcap"), (bench, "metadata.yaml")])
def test_no_report_has_the_name_of_a_file_of_a_bag(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], verb, name: str
) -> None:
    """Whether it is there or not; nothing is run."""
    there = written(tmp_path / "bag" / name, BAG)
    for file in (there, tmp_path / "other" / name):
        assert verb.main(["-o", str(file)], Quiet()) == 2
        assert "it has the name of a file of a bag" in capsys.readouterr().err
    assert files_in(tmp_path) == {tmp_path / "bag": None, there: BAG.encode()}
