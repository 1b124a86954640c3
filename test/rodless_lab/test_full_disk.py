# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Whoever makes a folder looks first whether the disk has room: a refusal leaves nothing of it."""

import errno
from collections.abc import Callable
from pathlib import Path

import pytest
from no_room import no_room

from rodless_lab.accuracy.campaign import campaign
from rodless_lab.results_folder import results_folder
from rodless_lab.studies.store import Store
from rodless_lab.studies.study import read_study
from rodless_lab.studies.tune import Candidates
from rodless_lab.studies.tuning_task import read_task

Opening = Callable[[Path], object]


def of_a_demo(folder: Path) -> None:
    """Claim the folder of a demo, and write there."""
    with results_folder(folder):
        (folder / "metrics.json").touch()


def of_a_sweep() -> Opening:
    """Open the data set of a study."""
    study = read_study("friction")
    return lambda folder: Store(folder, study).close()


def of_a_search() -> Opening:
    """Open the journal of a task."""
    task = read_task("pid")
    return lambda folder: Candidates(folder, task).close()


def of_a_campaign(folder: Path) -> None:
    """Begin a campaign of no rigs."""
    campaign(folder / "campaign.csv", 0, lambda _: None, lambda: False)


@pytest.mark.parametrize(
    "chosen", [lambda: of_a_demo, of_a_sweep, of_a_search, lambda: of_a_campaign]
)
def test_a_full_disk_is_refused_before_a_folder_is_made(
    tmp_path: Path, chosen: Callable[[], Opening]
) -> None:
    """Empty files and folders can still be made there; with room the same opens."""
    opening, folder = chosen(), tmp_path / "above" / "results"
    with no_room(), pytest.raises(OSError, match="File too large") as caught:
        opening(folder)
    assert (caught.value.errno, list(tmp_path.iterdir())) == (errno.EFBIG, [])
    assert str(caught.value.filename).startswith(str(folder))
    opening(folder)
    assert any(folder.parent.iterdir())
