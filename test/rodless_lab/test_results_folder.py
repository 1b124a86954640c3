# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Verbs that write several files into a folder: one at a time, as the files belong together."""

import errno
import fcntl
import os
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest
from quiet_stop import Quiet

from rodless_base.start import Stop
from rodless_lab.cli import bench, experiment, laws
from rodless_lab.results_folder import results_folder

VERBS: tuple[tuple[Callable[[Sequence[str], Stop], int], list[str], str, int], ...] = (
    (laws.main, ["--law", "pid", "--rigs", "1"], "laws", 2),
    (experiment.main, ["step"], "experiment", 2),
    (bench.main, ["--only", "solvers"], "bench", 2),
)


@pytest.mark.parametrize(
    ("main", "arguments", "what", "code"), VERBS, ids=[what for _, _, what, _ in VERBS]
)
def test_a_second_process_is_refused(
    main: Callable[[Sequence[str], Stop], int],
    arguments: list[str],
    what: str,
    code: int,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """In one line, before its work; the folder stays as it is."""
    output = tmp_path / "metrics.json" if what == "bench" else tmp_path
    with results_folder(tmp_path):
        assert main([*arguments, "--output", str(output)], Quiet()) == code
    assert capsys.readouterr().err == (
        f"{tmp_path}: cannot be written: another process writes there; wait for its end, or give "
        "another --output\n"
    )
    assert not list(tmp_path.iterdir())


def test_a_new_folder_that_gets_nothing_goes_again(tmp_path: Path) -> None:
    """With those made for it; one that was there, or that got something, stays."""
    with pytest.raises(KeyboardInterrupt), results_folder(tmp_path / "new" / "folder"):
        raise KeyboardInterrupt
    assert tmp_path.exists()
    assert not list(tmp_path.iterdir())
    with results_folder(tmp_path / "new" / "folder"):
        (tmp_path / "new" / "file").touch()
    assert [path.name for path in (tmp_path / "new").iterdir()] == ["file"]
    with results_folder(tmp_path / "new"):
        pass
    assert (tmp_path / "new").exists()


@pytest.mark.parametrize("number", [errno.EBADF, errno.ENOLCK, errno.ENOTSUP])
def test_a_file_system_without_locks_keeps_nobody_out(
    number: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As shared ones may be; any other error is one."""

    def refuse(*_: object) -> None:
        raise OSError(number, "no locks")

    monkeypatch.setattr(fcntl, "flock", refuse)
    with results_folder(tmp_path):
        pass
    number = errno.EIO
    with pytest.raises(OSError, match="no locks"), results_folder(tmp_path):
        pass


def test_a_process_forked_meanwhile_does_not_keep_the_folder(tmp_path: Path) -> None:
    """As a pool of a test's, which outlives it: its copy of the claim is no claim."""
    read, write = os.pipe()
    with results_folder(tmp_path):
        child = os.fork()
        if child == 0:
            os.close(write)
            os.read(read, 1)
            os._exit(0)
    with results_folder(tmp_path):
        pass
    os.close(write)
    os.waitpid(child, 0)
    os.close(read)
