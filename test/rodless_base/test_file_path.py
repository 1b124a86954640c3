# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What names no file is refused where a path is asked for, and the line names it."""

from collections.abc import Callable
from pathlib import Path, PurePosixPath

import numpy as np
import pytest

from rodless_base.file_path import file_path
from rodless_base.one_line import shown
from rodless_lab import read_bag, read_commands, read_run, sweep
from rodless_lab.bags.writer import BagWriter, recover_bag
from rodless_sim import RigParameters, Scenario, simulate


def save(path: object) -> None:
    """Save a trace."""
    simulate(RigParameters(), np.full(5, 5.0), 1e-3).save(path)  # type: ignore[arg-type]


def swept(path: object) -> None:
    """Sweep into a folder."""
    sweep("friction", path)  # type: ignore[arg-type]


TAKES_A_PATH = pytest.mark.parametrize(
    "take",
    [
        read_bag,
        read_run,
        read_commands,
        recover_bag,
        BagWriter,
        save,
        swept,
        RigParameters.from_file,
        Scenario.from_file,
    ],
)


@pytest.mark.parametrize("given", ["run1", Path("run1"), PurePosixPath("run1")])
def test_texts_and_paths_are_paths(given: object) -> None:
    """Whatever says its path itself is one."""
    assert file_path(given) == Path("run1")


@TAKES_A_PATH
@pytest.mark.parametrize("given", [5, None, b"run1", ["run1"], 1.5])
def test_what_is_no_path_is_refused_by_its_value(
    take: Callable[[object], object], given: object
) -> None:
    """Python itself names the type alone; 5 would even be taken for a file that is open."""
    with pytest.raises(TypeError) as caught:
        take(given)
    assert str(caught.value) == f"{given!r} refused, must be a path: a text or a pathlib.Path"


@TAKES_A_PATH
@pytest.mark.parametrize(
    ("given", "cause"),
    [
        ("", "it is empty"),
        ("run\0", "it has a NUL"),
        ("run\ud800", "it has half a character"),
        ("x" * 256, "it has a name of more than 255 bytes"),
        ("ä" * 128 + "/run", "it has a name of more than 255 bytes"),
    ],
)
def test_a_text_that_no_file_can_have_is_refused(
    take: Callable[[object], object], given: str, cause: str
) -> None:
    """An empty path would be the folder where one happens to be."""
    with pytest.raises(ValueError, match="refused, no file has this path") as caught:
        take(given)
    assert str(caught.value) == f"{shown(given)} refused, no file has this path: {cause}"


def test_the_longest_name_is_one() -> None:
    """255 bytes are what a file system takes, however many names there are."""
    assert file_path("/".join(["x" * 255] * 3)).name == "x" * 255
