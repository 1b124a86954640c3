# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Where the results cannot be written, that is said before minutes of work, not after them."""

from pathlib import Path

import pytest
from quiet_stop import Quiet

from rodless_base.atomic_write import check_writable
from rodless_lab.cli import animate, compare, identify, replay
from rodless_lab.cli.exit_code import exit_code


def never() -> None:
    """Stand for the work."""
    raise AssertionError


def test_a_folder_that_cannot_be_written_to_is_said_before_the_work(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Exit code 2 and one line that names the output."""
    (tmp_path / "file").write_text("mine")
    output = tmp_path / "file" / "run.gif"
    assert exit_code(never, output, output.parent) == 2
    assert capsys.readouterr().err == f"{output}: cannot be written: File exists\n"
    assert (tmp_path / "file").read_text() == "mine"


@pytest.mark.parametrize(
    ("verb", "arguments"),
    [
        (replay, "missing --output /proc/results"),
        (compare, "paper missing --output /proc/results"),
        (animate, "missing --output /proc/run.gif"),
        (identify, "valve missing --output /proc/found.yaml"),
    ],
    ids=["replay", "compare", "animate", "identify"],
)
def test_every_verb_looks_at_its_output_first(
    verb: object, arguments: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its bag, which is missing, has not been asked for yet."""
    assert verb.main(arguments.split(), Quiet()) == 2  # type: ignore[attr-defined]
    said = capsys.readouterr().err
    assert said.startswith(f"{arguments.rsplit(maxsplit=1)[-1]}: cannot be written: ")
    assert said.count("\n") == 1


def test_looking_leaves_nothing_behind(tmp_path: Path) -> None:
    """What is refused later has made no folder; one that is there keeps what it has."""
    check_writable(tmp_path / "new" / "results")
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "kept").touch()
    check_writable(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["kept"]
