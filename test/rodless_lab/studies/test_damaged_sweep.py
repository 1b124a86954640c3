# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What has changed in a sweep's folder is never taken for its results, and never waited for."""

import errno
import os
from collections.abc import Callable
from functools import partial
from pathlib import Path
from shutil import copy, copytree

import numpy as np
import pyarrow as arrow
import pytest
from pyarrow import parquet
from small_study import write_study

from rodless_lab import sweep
from rodless_lab.studies import part, parts
from rodless_lab.studies.errors import StudyError
from rodless_lab.studies.journal import Journal
from rodless_lab.studies.replay import replay_row
from rodless_lab.studies.saved_study import study_text
from rodless_lab.studies.seal import Seal
from rodless_lab.studies.study import Study, read_study
from rodless_lab.studies.sweep import run_sweep

PART = Path("rows", "part-00000.parquet")
JOURNAL = Path("rows", ".part-00000.jsonl")

Spoil = Callable[[Path], object]


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Study:
    """A study of three rows."""
    return read_study(write_study(tmp_path_factory.mktemp("study"), rows=3))


@pytest.fixture(scope="module")
def swept(study: Study, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of its sweep; not to be changed."""
    folder = tmp_path_factory.mktemp("swept")
    sweep(study, folder)
    return folder


@pytest.fixture
def whole(swept: Path, tmp_path: Path) -> Path:
    """A copy of it."""
    return Path(copytree(swept, tmp_path / "out"))


@pytest.fixture
def begun(study: Study, tmp_path: Path) -> Path:
    """The folder of a sweep that was interrupted after its second row."""
    folder = tmp_path / "begun"
    stopped = partial(next, iter((False, True)))
    assert not run_sweep(study, folder, 1, None, lambda *_: None, stopped)
    return folder


def test_a_part_that_cannot_be_read_is_not_called_damaged(
    study: Study, whole: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nobody is told to remove hours of work because a file could not be opened for a moment."""

    def fail(file: Path) -> bytes:
        raise PermissionError(errno.EACCES, "Permission denied", str(file))

    monkeypatch.setattr(part, "read_file", fail)
    with pytest.raises(PermissionError):
        sweep(study, whole)


def test_what_stands_in_place_of_a_part_is_left_alone(
    study: Study, whole: Path, tmp_path: Path
) -> None:
    """A link that leads nowhere was followed, and the part made there; other text was removed."""
    (whole / JOURNAL).write_text("my own words\n")
    with pytest.raises(StudyError, match="line 1 is damaged"):
        sweep(study, whole)
    assert (whole / JOURNAL).read_text() == "my own words\n"
    (whole / JOURNAL).unlink()
    (whole / PART).unlink()
    (whole / PART).symlink_to(tmp_path / "nowhere" / "part")
    with pytest.raises(StudyError, match=r"part-00000.parquet: damaged, No such file or directory"):
        sweep(study, whole)
    assert not (tmp_path / "nowhere").exists()


def test_a_line_that_finds_no_room_leaves_none_behind(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Half of it would spoil the next, and the journal with it; the error names the journal."""
    journal = Journal(tmp_path / "journal.jsonl", b"study")
    journal.add("first")
    write = os.write

    def full(descriptor: int, data: bytes) -> int:
        if len(data) < 20:
            raise OSError(errno.ENOSPC, "No space left on device")
        return write(descriptor, data[: len(data) - 10])

    with monkeypatch.context() as patch:
        patch.setattr(os, "write", full)
        with pytest.raises(OSError, match="No space left") as caught:
            journal.add("second")
    assert caught.value.filename == str(tmp_path / "journal.jsonl")
    journal.add("third")
    assert journal.known() == ["first", "third"]


def test_a_replay_without_rows_says_what_to_do(study: Study, tmp_path: Path) -> None:
    """The folder has a study and nothing else."""
    (tmp_path / "study.json").write_text(study_text(study))
    with pytest.raises(StudyError, match="run the sweep on first"):
        replay_row(tmp_path, 0)


def test_no_bit_of_a_part_can_change(swept: Path) -> None:
    """Wherever in the file: data, statistics, column names, the seal itself."""
    content = (swept / PART).read_bytes()
    seal = Seal((swept / "study.json").read_bytes(), PART.name)
    assert seal.holds(content)
    for place in range(len(content)):
        for bit in range(8):
            changed = bytearray(content)
            changed[place] ^= 1 << bit
            assert not seal.holds(bytes(changed)), (place, bit)


def cut(part: Path) -> None:
    part.write_bytes(part.read_bytes()[:300])


def emptied(part: Path) -> None:
    part.write_bytes(b"")


def folded(part: Path) -> None:
    part.unlink()
    part.mkdir()


def piped(part: Path) -> None:
    part.unlink()
    os.mkfifo(part)


def flipped(part: Path) -> None:
    """In the middle of the first page, which Parquet reads all the same."""
    content = bytearray(part.read_bytes())
    content[len(content) // 4] ^= 1
    part.write_bytes(content)


def sliced(part: Path) -> None:
    parquet.write_table(parquet.read_table(part).slice(0, 2), part)


def without_figures(part: Path) -> None:
    parquet.write_table(parquet.read_table(part).drop(["overshoot"]), part)


def with_column(name: str, values: arrow.Array) -> Spoil:
    def spoil(part: Path) -> None:
        table = parquet.read_table(part)
        place = table.column_names.index(name)
        parquet.write_table(table.set_column(place, name, values), part)

    return spoil


def of_other_noise(part: Path) -> None:
    """Another study has the same name of a part, and the same columns and rows."""
    path = write_study(part.parents[1], rows=3)
    path.write_text(path.read_text(encoding="utf-8").replace("seed: 7", "seed: 8"))
    sweep(path, part.parents[1] / "other")
    copy(part.parents[1] / "other" / PART, part)


@pytest.mark.parametrize(
    "spoil",
    [
        *(cut, emptied, folded, piped, flipped, sliced, without_figures, of_other_noise),
        with_column("overshoot", arrow.array(["0.1"] * 3)),
        with_column("overshoot", arrow.array([None] * 3, arrow.float64())),
        with_column("row", arrow.array([0.0, 1.0, 2.0])),
        with_column("seed", arrow.array(["a"] * 3)),
        with_column("failure", arrow.array([1] * 3)),
        with_column("failure", arrow.array([None] * 3, arrow.string())),
        with_column("cylinder.moving_mass", arrow.array([9.9] * 3)),
        with_column("trace.position", arrow.array(["z"] * 3)),
    ],
)
def test_a_damaged_part_is_named_and_can_be_made_anew(
    study: Study, whole: Path, spoil: Spoil
) -> None:
    """Whatever has changed in it: one line says which file, and without it all ends as before."""
    part = whole / PART
    before = part.read_bytes()
    spoil(part)
    for read in (lambda: sweep(study, whole), lambda: replay_row(whole, 0)):
        with pytest.raises(StudyError, match=r"part-00000\.parquet: damaged, [^\n]*; remove it, "):
            read()
    if part.is_dir():
        part.rmdir()
    else:
        part.unlink()
    sweep(study, whole)
    assert part.read_bytes() == before


@pytest.fixture
def of_two_parts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Study:
    """A study of four rows, two to a part."""
    monkeypatch.setattr(parts, "PART", 2)
    return read_study(write_study(tmp_path, rows=4))


def test_parts_that_have_changed_places_are_damaged(of_two_parts: Study, tmp_path: Path) -> None:
    """Each is whole and of the same study; their rows are others."""
    folder = tmp_path / "out"
    sweep(of_two_parts, folder)
    copy(folder / "rows" / "part-00001.parquet", folder / PART)
    with pytest.raises(StudyError, match=r"part-00000\.parquet: damaged, not as this sweep wrote"):
        sweep(of_two_parts, folder)


@pytest.mark.parametrize(
    "name", ["part-00000 (copy).parquet", "part-00001.parquet", "a.parquet", "notes.txt", "old/a"]
)
def test_what_is_no_part_of_a_sweep_is_not_read_with_it(
    study: Study, whole: Path, name: str
) -> None:
    """Every reader of the data set would take its rows for ours; what is hidden none takes."""
    (whole / "rows" / ".hidden").touch()
    stranger = whole / "rows" / name
    stranger.parent.mkdir(exist_ok=True)
    copy(whole / PART, stranger)
    top = whole / "rows" / Path(name).parts[0]
    for read in (lambda: sweep(study, whole), lambda: replay_row(whole, 0)):
        with pytest.raises(StudyError) as refusal:
            read()
        assert str(refusal.value) == (
            f"{top}: no part of this sweep, but read with its rows; move it elsewhere"
        )
    stranger.unlink()
    if top.is_dir():
        top.rmdir()
    assert sweep(study, whole).complete


@pytest.mark.parametrize("file", [JOURNAL, Path("study.json"), Path(".lock")])
@pytest.mark.parametrize(
    ("make", "what"),
    [(os.mkfifo, "not a file but a pipe or device"), (os.mkdir, "Is a directory")],
)
def test_what_is_no_file_is_refused_at_once(
    study: Study, begun: Path, file: Path, make: Spoil, what: str
) -> None:
    """A pipe was waited for without end, and two requests to stop were needed."""
    (begun / file).unlink()
    make(begun / file)
    with pytest.raises(StudyError) as refusal:
        sweep(study, begun)
    assert str(refusal.value) == f"{begun / file}: {what}; remove it, or give another --output"


def test_a_study_that_is_a_pipe_is_not_waited_for_by_a_replay(whole: Path) -> None:
    """It is refused as in a sweep."""
    (whole / "study.json").unlink()
    os.mkfifo(whole / "study.json")
    with pytest.raises(StudyError, match=r"study\.json: not a file but a pipe or device; remove"):
        replay_row(whole, 0)


@pytest.mark.parametrize("file", [JOURNAL, Path(".lock")])
@pytest.mark.parametrize("text", ["precious without newline", "", None])
def test_a_link_in_place_of_a_file_is_not_followed(
    study: Study, begun: Path, tmp_path: Path, file: Path, text: str | None
) -> None:
    """What it leads to stays as it is, and is not made where it is missing."""
    victim = tmp_path / "victim.txt"
    if text is not None:
        victim.write_text(text)
    (begun / file).unlink()
    (begun / file).symlink_to(victim)
    with pytest.raises(StudyError, match="a symbolic link, which is not followed; remove it, or"):
        sweep(study, begun)
    assert (victim.read_text() if victim.exists() else None) == text


@pytest.mark.parametrize(
    "change",
    [
        lambda line: line.replace(b"0.0", b"0.1", 1),
        lambda line: line.replace(b'"traces": {', b'"traces": {"a": 1, ', 1),
        lambda line: line.replace(b'"failure": ""', b'"failure": "\\ud800"'),
        lambda line: line.replace(b'"failure": ""', b'"failure": "a\\nb\\u001b[31m"'),
        lambda line: line[20:-2] + b"\n",
        lambda line: line[:40] + b"\n",
        lambda line: bytes(len(line) - 1) + b"\n",
        lambda _: b"[" * 100_000 + b"\n",
        lambda _: b"\n",
    ],
)
def test_a_changed_line_of_a_journal_is_named_when_it_is_read(
    study: Study, begun: Path, change: Callable[[bytes], bytes]
) -> None:
    """Before a row is run: file, line and the way out, and nothing is written."""
    journal = begun / JOURNAL
    first, second = journal.read_bytes().splitlines(keepends=True)
    assert change(second) != second
    journal.write_bytes(first + change(second))
    before = journal.read_bytes()
    with pytest.raises(StudyError) as refusal:
        sweep(study, begun, progress=lambda *_: pytest.fail("a row was run"))
    assert str(refusal.value) == (
        f"{journal}: line 2 is damaged; remove that line, or give another --output"
    )
    assert journal.read_bytes() == before


def test_the_journal_of_another_part_is_damaged(of_two_parts: Study, tmp_path: Path) -> None:
    """Its lines are whole and of the same study."""
    folder, stopped = tmp_path / "out", partial(next, iter((False, False, True)))
    run_sweep(of_two_parts, folder, 1, None, lambda *_: None, stopped)
    (folder / PART).unlink()
    copy(folder / "rows" / ".part-00001.jsonl", folder / JOURNAL)
    with pytest.raises(StudyError, match=r"\.part-00000\.jsonl: line 1 is damaged"):
        sweep(of_two_parts, folder)


def test_a_text_that_is_no_line_of_ours_is_kept(study: Study, begun: Path) -> None:
    """Without an end of its line, too: only a line that was begun may be cut off."""
    (begun / JOURNAL).write_bytes(b"precious without newline")
    with pytest.raises(StudyError, match="line 1 is damaged"):
        sweep(study, begun)
    assert (begun / JOURNAL).read_bytes() == b"precious without newline"


@pytest.mark.parametrize("kept", [0, 1, 2, 10, 18, 19, 20, 50, -1])
@pytest.mark.parametrize("zeros", [0, 100])
def test_a_line_that_was_begun_is_run_again(
    study: Study, swept: Path, begun: Path, kept: int, zeros: int
) -> None:
    """Wherever it was cut, and with zeros behind it, as after a crash of the machine."""
    journal = begun / JOURNAL
    first, second = journal.read_bytes().splitlines(keepends=True)
    journal.write_bytes(first + second[:kept] + bytes(zeros))
    counts: list[int] = []
    sweep(study, begun, progress=lambda known, _total: counts.append(known))
    assert counts == [2, 3]
    assert (begun / PART).read_bytes() == (swept / PART).read_bytes()


def test_numbers_that_are_none_are_the_same_whether_or_not_a_sweep_was_interrupted(
    tmp_path: Path,
) -> None:
    """There are two signs of NaN, of which the lines of a journal know one."""
    journal, negative = Journal(tmp_path / "a.jsonl", b""), float(np.copysign(np.nan, -1.0))
    (found,) = journal.add([negative])
    ((again,),) = journal.known()
    assert np.float64(found).tobytes() == np.float64(again).tobytes()
