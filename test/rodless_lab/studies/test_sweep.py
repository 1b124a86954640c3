# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A sweep: each row as if it were alone, and none lost or done twice whatever interrupts it."""

import hashlib
import importlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from pyarrow import parquet
from small_study import write_law, write_study

from rodless_control.laws import law_class
from rodless_lab import closed_loop, run_metrics, sweep
from rodless_lab.studies import parts, report, saved_study
from rodless_lab.studies.errors import StudyError
from rodless_lab.studies.replay import replay_row
from rodless_lab.studies.results import read_results
from rodless_lab.studies.row_run import RowResult, RowRunner
from rodless_lab.studies.store import Store
from rodless_lab.studies.study import Row, read_study
from rodless_lab.studies.sweep import run_sweep


def files(folder: Path) -> dict[str, bytes]:
    """What a folder's data set holds, by name."""
    return {file.name: file.read_bytes() for file in (folder / "rows").iterdir()}


def silent(_known: int, _total: int) -> None:
    """Tell nobody."""


@pytest.mark.parametrize("row", [0, 13])
def test_a_row_is_the_closed_loop_of_its_parameters(tmp_path: Path, row: int) -> None:
    """Figures and decimated traces to the bit, its axes and its seed beside them."""
    study = read_study(write_study(tmp_path))
    found = sweep(study, tmp_path / "out")
    base = study.row(row).base
    run = closed_loop(base.rig, base.controller, base.reference, 0.1, 1e-3)
    for name, value in run_metrics(run)._asdict().items():
        assert np.array_equal([found[name][row]], [value], equal_nan=True), name
    assert np.array_equal(found["trace.position"][row], run.position[::20])
    assert np.array_equal(found["trace.voltage"][row], run.voltage[::20])
    assert found["cylinder.moving_mass"][row] == base.rig["cylinder.moving_mass"]
    assert found["seed"][row] == base.rig["sensors.seed"]
    assert len(set(found["seed"])) == len(found) == 20


def test_its_page_needs_no_traces(tmp_path: Path) -> None:
    """Of many rows they would fill the memory: read without, all else is the same."""
    study = read_study(write_study(tmp_path))
    whole = sweep(study, tmp_path / "out").columns()
    bare = read_results(tmp_path / "out", study, traces=False).columns()
    assert {"trace.position", "trace.voltage"} <= whole.keys() - bare.keys()
    assert list(bare) == [name for name in whole if not name.startswith("trace.")]
    for name, values in bare.items():
        assert np.array_equal(values, whole[name], equal_nan=values.dtype.kind == "f"), name


def test_the_page_of_many_rows_draws_some_and_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a million the picture and its table would fill the memory; each dot is a row's."""
    monkeypatch.setattr(report, "MOST_DRAWN", 7)
    study = read_study(write_study(tmp_path))
    found = sweep(study, tmp_path / "out")
    assert "20 rows." in report.write_report(tmp_path / "out", study)
    page = (tmp_path / "out" / "summary.md").read_text(encoding="utf-8")
    assert "![Figures over each axis: 7 of the 20 rows, at random](rows.png)" in page
    lines = (tmp_path / "out" / "rows.csv").read_text(encoding="utf-8").splitlines()
    (across,) = [line for line in lines if line.startswith("# panel 1: x: cylinder.moving_mass")]
    figure = across.partition("; y: ")[2]
    points = [tuple(map(float, line.split(",")[2:])) for line in lines if line.startswith("1,")]
    assert len(set(points)) == 7, figure
    masses = found["cylinder.moving_mass"].tolist()
    assert {mass for mass, _ in points} < set(masses)
    assert [mass for mass, _ in points] == [one for one in masses if one in dict(points)]


def test_the_files_depend_neither_on_threads_nor_on_interruptions(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One thread, three, or stopped after every third row: the same bytes."""
    monkeypatch.setattr(parts, "PART", 8)
    study = read_study(write_study(tmp_path))
    one, three, often = (tmp_path / name for name in ("one", "three", "often"))
    sweep(study, one, workers=1)
    sweep(study, three, workers=3)
    sittings = 0
    while True:
        asked = iter((False, False, True))
        sittings += 1
        if run_sweep(study, often, 1, None, silent, partial(next, asked)):
            break
    assert sittings == 7
    assert len(files(one)) == 3
    assert files(one) == files(three) == files(often)


def test_a_killed_sweep_goes_on_where_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """SIGKILL in the middle: no row is lost, none is run twice but the one in hand, same bytes."""
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    noted = tmp_path / "noted.txt"
    monkeypatch.setenv("NOTED", str(noted))
    path = write_study(tmp_path, law=write_law(tmp_path), rows=12, duration=0.3)
    script = f"from rodless_lab import sweep; sweep({str(path)!r}, {str(tmp_path / 'killed')!r})"
    # The fourth row holds until the process is killed.
    held = {**os.environ, "HELD_AT": "4"}
    with subprocess.Popen([sys.executable, "-c", script], env=held) as process:
        journal = tmp_path / "killed" / "rows" / ".part-00000.jsonl"
        deadline = time.monotonic() + 300.0
        while not (journal.exists() and journal.read_bytes().count(b"\n") >= 3):
            assert process.poll() is None
            assert time.monotonic() < deadline
            time.sleep(0.01)
        process.send_signal(signal.SIGKILL)
    kept = journal.read_bytes().count(b"\n")
    assert kept == 3
    begun = noted.read_text(encoding="utf-8").splitlines()
    assert kept <= len(begun) <= kept + 1

    sweep(path, tmp_path / "killed")
    runs = noted.read_text(encoding="utf-8").splitlines()
    # Whatever was known before is not run again.
    assert len(runs) == len(begun) + 12 - kept
    assert set(begun[:kept]).isdisjoint(runs[len(begun) :])
    sweep(path, tmp_path / "whole")
    assert files(tmp_path / "killed") == files(tmp_path / "whole")


def test_a_line_that_a_crash_has_cut_is_run_again(tmp_path: Path) -> None:
    """Half a line in the journal is no row; the whole lines before it are."""
    study = read_study(write_study(tmp_path))
    folder = tmp_path / "cut"
    asked = iter((False, False, False, True))
    assert not run_sweep(study, folder, 1, None, silent, lambda: next(asked))
    journal = folder / "rows" / ".part-00000.jsonl"
    lines = journal.read_bytes().splitlines(keepends=True)
    journal.write_bytes(b"".join(lines[:2]) + lines[2][:40])
    counts: list[int] = []
    sweep(study, folder, progress=lambda known, _total: counts.append(known))
    assert counts == list(range(3, 21))
    sweep(study, tmp_path / "whole")
    assert files(folder) == files(tmp_path / "whole")


def test_a_complete_sweep_runs_nothing(tmp_path: Path) -> None:
    """The second time there is nothing left to do, and nothing is written."""
    study = read_study(write_study(tmp_path))
    sweep(study, tmp_path / "out")
    before = files(tmp_path / "out")
    sweep(study, tmp_path / "out", progress=lambda *_: pytest.fail("a row was run"))
    assert files(tmp_path / "out") == before


def test_results_of_another_study_are_left_alone(tmp_path: Path) -> None:
    """A folder is for one study; the text says the way out."""
    sweep(read_study(write_study(tmp_path)), tmp_path / "out")
    before = files(tmp_path / "out")
    other = read_study(write_study(tmp_path, rows=21))
    with pytest.raises(
        StudyError, match=r"holds the results of another study.* differs in count; .*--output"
    ):
        sweep(other, tmp_path / "out")
    assert files(tmp_path / "out") == before


def test_two_sweeps_at_once_do_not_share_a_folder(tmp_path: Path) -> None:
    """The second is refused while the first has it open, and not after."""
    study = read_study(write_study(tmp_path))
    first = Store(tmp_path / "out", study)
    with pytest.raises(StudyError, match="another process writes there"):
        Store(tmp_path / "out", study)
    first.close()
    Store(tmp_path / "out", study).close()


def test_the_data_set_is_read_by_others_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Pyarrow reads the folder as one table with units; pandas too; what fails says why."""
    import pandas as pd  # noqa: PLC0415

    monkeypatch.setattr(parts, "PART", 8)
    found = sweep(read_study(write_study(tmp_path)), tmp_path / "out")
    table = parquet.read_table(tmp_path / "out" / "rows")
    assert table["row"].to_pylist() == list(range(20))
    assert table.schema.field("air").metadata == {b"unit": b"kg"}
    frame = pd.read_parquet(tmp_path / "out" / "rows")
    assert np.array_equal(frame["mean_error"], found["mean_error"])
    assert (found.failures, found.complete) == ({}, True)


def test_an_axis_has_one_type_in_all_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whole numbers in the first file and fractions in the second are read as one column."""
    monkeypatch.setattr(parts, "PART", 2)
    path = tmp_path / "study.yaml"
    path.write_text(
        "set: {reference.at: 0.0}\nrun: {duration: 0.02}\n"
        "vary: {cylinder.moving_mass: [1, 1.5], "
        "supply.pressure: [500000, 600000]}",
        encoding="utf-8",
    )
    found = sweep(path, tmp_path / "out")
    assert found["cylinder.moving_mass"].tolist() == [1.0, 1.0, 1.5, 1.5]
    table = parquet.read_table(tmp_path / "out" / "rows")
    assert str(table.schema.field("cylinder.moving_mass").type) == "double"
    assert str(table.schema.field("supply.pressure").type) == "int64"


def test_a_law_that_was_changed_is_another_study(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Rows of a user's law before and after an edit are not put together."""
    study = read_study(write_study(tmp_path))
    run_sweep(study, tmp_path / "out", 1, None, silent, lambda: True)
    monkeypatch.setattr(saved_study, "law_digests", lambda _controllers: ["edited"])
    with pytest.raises(StudyError, match=r"holds the results of another study.* differs in laws;"):
        run_sweep(study, tmp_path / "out", 1, None, silent)
    with pytest.raises(StudyError, match="made with another version of the law, whose file has"):
        replay_row(tmp_path / "out", 0)
    monkeypatch.undo()
    file = tmp_path / "out" / "study.json"
    other = file.read_text(encoding="utf-8").replace('"controller.kp"', '"controller.gain"')
    file.write_text(other, encoding="utf-8")
    with pytest.raises(
        StudyError, match=r"controller\.gain: .*; it is not there here, or made with"
    ):
        replay_row(tmp_path / "out", 0)


def test_a_study_is_sealed_with_the_law_that_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A law's file that was edited since its import is not what runs; the next import is."""
    monkeypatch.syspath_prepend(tmp_path)
    file = tmp_path / "sealed_law.py"
    text = (
        "from rodless_control import Law\n\n\nclass Sealed(Law):\n"
        "    def update(self, measurement, reference, interval):\n        return 5.0\n"
    )
    file.write_text(text, encoding="utf-8")
    law = law_class("sealed_law:Sealed")
    file.write_text(f"{text}# edited\n", encoding="utf-8")
    study = read_study(write_study(tmp_path, "sealed_law:Sealed"))
    assert study.base.controller.LAW_CLASS is law
    before, after = (
        hashlib.sha256(source.encode()).hexdigest()[:16] for source in (text, f"{text}# edited\n")
    )
    assert json.loads(saved_study.study_text(study))["laws"] == [before]
    again = importlib.reload(sys.modules["sealed_law"]).Sealed
    assert after == again.SOURCE_DIGEST


def test_a_row_is_replayed_to_the_bit_and_a_change_is_seen(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Equal as it stands; what another machine has computed otherwise, by a bit, is named."""
    study, run = read_study(write_study(tmp_path)), RowRunner.__call__

    def otherwise(runner: RowRunner, row: Row) -> RowResult:
        found = run(runner, row)
        if row.number == 17:
            found.traces["voltage"][2] += 1e-12
            rms_error = np.nextafter(found.metrics.rms_error, 1.0)
            return found._replace(metrics=found.metrics._replace(rms_error=rms_error))
        return found

    with monkeypatch.context() as elsewhere:
        elsewhere.setattr(RowRunner, "__call__", otherwise)
        sweep(study, tmp_path / "out")
    differences = replay_row(tmp_path / "out", 17)
    assert [one.partition(":")[0] for one in differences] == ["rms_error", "trace.voltage"]
    assert replay_row(tmp_path / "out", 16) == []
    with pytest.raises(StudyError, match=r"^row 20 refused: .* has rows 0 to 19$"):
        replay_row(tmp_path / "out", 20)


def test_a_row_that_fails_is_not_said_to_be_equal_over_the_nodes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In process it is replayed; the nodes do not end a run that fails, and are not asked."""
    run = RowRunner.__call__
    monkeypatch.setattr(RowRunner, "__call__", lambda *given: run(*given)._replace(failure="stuck"))
    sweep(read_study(write_study(tmp_path, rows=2)), tmp_path / "out")
    assert replay_row(tmp_path / "out", 1) == []
    with pytest.raises(StudyError, match=r"^row 1 refused: its run fails \(stuck\), and the nodes"):
        replay_row(tmp_path / "out", 1, ros=True)


@pytest.mark.ros
def test_a_row_is_replayed_by_the_nodes(tmp_path: Path) -> None:
    """Over DDS in lock-step plant and controller give the same samples, noise and all."""
    study = read_study(write_study(tmp_path, rows=2))
    sweep(study, tmp_path / "out")
    assert replay_row(tmp_path / "out", 1, ros=True) == []


def test_a_damaged_study_beside_the_results_is_refused(tmp_path: Path) -> None:
    """In a sentence, for a replay."""
    sweep(read_study(write_study(tmp_path, rows=1)), tmp_path / "out")
    file = tmp_path / "out" / "study.json"
    content = json.loads(file.read_text(encoding="utf-8"))
    del content["vary"]
    file.write_text(json.dumps(content), encoding="utf-8")
    with pytest.raises(StudyError, match="damaged"):
        replay_row(tmp_path / "out", 0)
    file.write_bytes(b"\xff")
    with pytest.raises(
        StudyError, match=r"study\.json: damaged \('utf-8' .*\); run the study into another folder"
    ):
        replay_row(tmp_path / "out", 0)
    with pytest.raises(StudyError, match=r"out: holds .*study\.json differs in all; give another"):
        sweep(read_study(write_study(tmp_path, rows=1)), tmp_path / "out")
    with pytest.raises(StudyError, match="no sweep there"):
        replay_row(tmp_path, 0)


def test_no_worker_is_refused(tmp_path: Path) -> None:
    """In one line, before a folder is made."""
    with pytest.raises(ValueError, match=r"^workers 0 refused: must be from 1 to 1000$"):
        sweep(write_study(tmp_path), tmp_path / "out", workers=0)
    assert not os.path.lexists(tmp_path / "out")


@pytest.mark.parametrize(("room", "at_once"), [(100, 8), (3, 3), (0, 1)])
def test_no_more_rows_run_at_once_than_there_is_memory_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, room: int, at_once: int
) -> None:
    """Of eight threads that are asked for, as many as there is room for runs; one at least."""
    asked: list[int | None] = []

    def noted(work: Callable[[Row], None], rows: Iterable[Row], workers: int) -> Iterator[None]:
        asked.append(workers)
        return map(work, rows)

    monkeypatch.setattr("rodless_lab.simulation.closed_loop.room_for", lambda _size: room)
    monkeypatch.setattr("rodless_lab.studies.sweep.in_order", noted)
    assert len(sweep(read_study(write_study(tmp_path)), tmp_path / "out", workers=8)) == 20
    assert asked == [at_once]
