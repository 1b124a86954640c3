# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The compile cache: private, checked, and never the reason why something does not run."""

import errno
import hashlib
import importlib
import logging
import os
import pickle
import stat
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numba
import pytest
from unmeasured import unmeasured

from rodless_base import kernel_cache, kernels
from rodless_base.kernel_cache import KernelCache, private_folder


def plus_one(x: float) -> float:
    """What is compiled here."""
    return x + 1.0


def itself(x: Any) -> Any:
    """What is compiled here, for several types."""
    return x


def use(folder: Path) -> int:
    """Call the kernel as a new process would; return how much of it came from the cache."""
    compiled = numba.njit(plus_one)
    kernels._keep(compiled, folder)
    assert compiled(2.0) == 3.0
    return sum(compiled.stats.cache_hits.values())


@pytest.fixture
def said(caplog: pytest.LogCaptureFixture) -> Iterator[Callable[[], list[str]]]:
    """Return what has been said, and let everything be said again."""
    kernel_cache.complain.cache_clear()
    caplog.set_level(logging.WARNING, logger="rodless_sim")
    yield lambda: [record.getMessage() for record in caplog.records]
    kernel_cache.complain.cache_clear()


def only(folder: Path, suffix: str) -> Path:
    """Return the one file of this kind."""
    (found,) = folder.rglob(f"*{suffix}")
    return found


def flip(content: bytes) -> bytes:
    """One bit in the middle."""
    middle = len(content) // 2
    return content[:middle] + bytes([content[middle] ^ 1]) + content[middle + 1 :]


DAMAGES: dict[str, Callable[[bytes], bytes]] = {
    "empty": lambda _: b"",
    "half": lambda content: content[: len(content) // 2],
    "a bit flipped": flip,
    "the checksum cut": lambda content: content[:7],
}


@pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES)
@pytest.mark.parametrize("suffix", [".nbi", ".nbc"])
def test_a_damaged_file_is_made_anew(
    tmp_path: Path, said: Callable[[], list[str]], suffix: str, damage: Callable[[bytes], bytes]
) -> None:
    """Index or code: the result is right, one line names the file, the next process has a hit."""
    assert (use(tmp_path), use(tmp_path)) == (0, 1)
    file = only(tmp_path, suffix)
    file.write_bytes(damage(file.read_bytes()))
    assert use(tmp_path) == 0
    assert said() == [f"a file of compiled code is damaged, compiling anew: {file}"]
    assert use(tmp_path) == 1
    assert len(said()) == 1


@pytest.mark.parametrize("suffix", [".nbi", ".nbc"])
def test_a_pipe_in_place_of_a_file_holds_nobody(
    tmp_path: Path, said: Callable[[], list[str]], suffix: str
) -> None:
    """Nobody writes into it: it is not waited for, and the file takes its place."""
    use(tmp_path)
    file = only(tmp_path, suffix)
    file.unlink()
    os.mkfifo(file)
    assert use(tmp_path) == 0
    line = f"not a file but a pipe or device, in place of compiled code, compiling anew: {file}"
    assert set(said()) == {line}
    assert use(tmp_path) == 1


@pytest.mark.parametrize("suffix", [".nbi", ".nbc"])
def test_a_file_that_numba_cannot_read_is_made_anew(
    tmp_path: Path, said: Callable[[], list[str]], suffix: str
) -> None:
    """Whole, but of another numba's content."""
    use(tmp_path)
    content = pickle.dumps(("what", "else"))
    only(tmp_path, suffix).write_bytes(hashlib.sha256(content).digest() + content)
    assert use(tmp_path) == 0
    (line,) = said()
    assert line.startswith("compiled code cannot be read, compiling anew: ")
    assert "\n" not in line
    assert use(tmp_path) == 1


PAIR = """
from typing import NamedTuple

class Pair(NamedTuple):
    first: float
"""


def first_of(pair: Any) -> Any:
    """What is compiled here, for a class."""
    return pair.first


@pytest.mark.parametrize("reloaded", [False, True])
def test_nothing_is_kept_of_a_class_that_was_loaded_twice(
    tmp_path: Path,
    said: Callable[[], list[str]],
    monkeypatch: pytest.MonkeyPatch,
    reloaded: bool,
) -> None:
    """As in a notebook that reloads modules: the next process would find a class that it has not.

    It would refuse the code, at each start, until somebody has deleted the folder.
    """
    name = f"pair_{reloaded}".lower()
    (tmp_path / f"{name}.py").write_text(PAIR, encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    module = importlib.import_module(name)
    pair = module.Pair(2.0)
    if reloaded:
        importlib.reload(module)
    folder = tmp_path / "cache"
    folder.mkdir()
    compiled = numba.njit(first_of)
    kernels._keep(compiled, folder)
    assert compiled(pair) == 2.0
    assert bool(list(folder.rglob("*.nbc"))) != reloaded
    assert bool(said()) == reloaded
    if reloaded:
        assert (
            "cannot be kept, the next start compiles anew: a class in it cannot be imported"
            in said()[0]
        )


def test_code_for_a_class_that_a_process_lacks_is_in_nobody_s_way(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A user's module has called a kernel with a class of its own: others use the cache as before.

    So does the user, with what was kept for the class before the others wrote.
    """
    name = "pair_of_a_user"
    (tmp_path / f"{name}.py").write_text(PAIR, encoding="utf-8")
    folder = tmp_path / "cache"
    folder.mkdir()

    def hits(*arguments: Any) -> int:
        compiled = numba.njit(itself)
        kernels._keep(compiled, folder)
        assert compiled(*arguments) == arguments[0]
        return sum(compiled.stats.cache_hits.values())

    with monkeypatch.context() as user:
        user.syspath_prepend(str(tmp_path))
        pair = importlib.import_module(name).Pair(2.0)
        assert hits(pair) == 0
    module = sys.modules.pop(name)
    assert (hits(2.0), hits(2.0)) == (0, 1)
    monkeypatch.setitem(sys.modules, name, module)
    assert hits(pair) == 1


def kept(folder: Path) -> tuple[Any, KernelCache]:
    """Return the kernel, compiled for a real and an integer, and a cache that holds neither."""
    compiled = numba.njit(itself)
    compiled(2.0)
    compiled(2)
    kernels._keep(compiled, folder)
    return compiled, compiled._cache


def test_processes_that_save_at_once_keep_what_each_has(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """None writes an index that it has read before another's code was in it."""
    compiled, cache = kept(tmp_path)
    both_have_read = threading.Barrier(2)
    read = kernel_cache._CheckedFiles._load_index

    def read_with_the_other(self: Any) -> dict[Any, str]:
        found = read(self)
        with suppress(threading.BrokenBarrierError):
            both_have_read.wait(0.2)  # in vain
        return found

    with monkeypatch.context() as patch:
        patch.setattr(kernel_cache._CheckedFiles, "_load_index", read_with_the_other)
        savers = [
            threading.Thread(target=cache.save_overload, args=one)
            for one in compiled.overloads.items()
        ]
        for saver in savers:
            saver.start()
        for saver in savers:
            saver.join()
    for types in compiled.overloads:
        found: Any = cache.load_overload(types, compiled.targetctx)
        assert found.signature.args == types


def test_code_for_other_types_is_none(tmp_path: Path) -> None:
    """Where two processes have given their code the same file: there it is compiled anew."""
    compiled, cache = kept(tmp_path)
    real, whole = compiled.overloads
    for types in (real, whole):
        cache.save_overload(types, compiled.overloads[types])
    files = cache._cache_file
    of_real, of_whole = files._load_index().values()
    Path(files._data_path(of_whole)).write_bytes(Path(files._data_path(of_real)).read_bytes())
    assert cache.load_overload(real, compiled.targetctx) is not None
    assert cache.load_overload(whole, compiled.targetctx) is None


def test_a_folder_that_cannot_be_locked_costs_the_cache_and_nothing_else(
    tmp_path: Path, said: Callable[[], list[str]]
) -> None:
    """A pipe stands in place of the lock, whose other end nobody opens."""
    _, cache = kept(tmp_path)
    os.mkfifo(Path(cache.cache_path) / kernel_cache.LOCK)
    assert (use(tmp_path), use(tmp_path)) == (0, 0)
    (line,) = said()
    assert "the next start compiles anew: not a file but a pipe or device: " in line


def test_who_stands_while_it_writes_holds_nobody_for_good(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As a process that was stopped: the others go on without the lock."""
    monkeypatch.setattr(kernel_cache, "PATIENCE", [0.05])
    _, cache = kept(tmp_path)
    with kernel_cache._locked(Path(cache.cache_path)):
        assert (use(tmp_path), use(tmp_path)) == (0, 1)


def test_a_file_system_without_locks_keeps_compiled_code(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As shared ones may be."""

    def refuse(*_: object) -> None:
        raise OSError(errno.ENOLCK, "no locks")

    monkeypatch.setattr(kernel_cache.fcntl, "flock", refuse)
    assert (use(tmp_path), use(tmp_path)) == (0, 1)


def test_compiling_is_announced_once_and_loading_is_not(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """A cold cache says how long it will take; a warm one says nothing."""
    caplog.set_level(logging.INFO, logger="rodless_sim")
    said = []
    for _ in range(2):
        kernel_cache.announce.cache_clear()
        use(tmp_path)
        said.append([record.getMessage() for record in caplog.records])
        caplog.clear()
    (line,), nothing = said
    assert "about a minute" in line
    assert nothing == []


def test_compiling_is_announced_where_nobody_has_set_up_logging(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A user's first `closed_loop` in Python says why it takes so long, on stderr."""
    monkeypatch.setattr(kernel_cache.LOGGER, "hasHandlers", lambda: False)
    kernel_cache.announce.cache_clear()
    use(tmp_path)
    assert capsys.readouterr().err.startswith("compiling, which takes about a minute")


def test_a_full_disk_costs_the_cache_and_nothing_else(
    tmp_path: Path, said: Callable[[], list[str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The kernel runs, one line says what it means, and later there is room again."""

    @contextmanager
    def full(*_: object) -> Iterator[None]:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        yield

    with monkeypatch.context() as patch:
        patch.setattr(kernel_cache._CheckedFiles, "_open_for_write", full)
        assert (use(tmp_path), use(tmp_path)) == (0, 0)
    (line,) = said()
    assert "No space left on device" in line
    assert "the next start compiles anew" in line
    assert (use(tmp_path), use(tmp_path)) == (0, 1)


def test_the_folder_is_the_user_s_alone(tmp_path: Path) -> None:
    """Made with mode 700, whatever the mask; one that was open to others is closed."""
    before = os.umask(0)
    try:
        made = private_folder(tmp_path / "deep" / "new")
    finally:
        os.umask(before)
    opened = tmp_path / "open"
    opened.mkdir()
    opened.chmod(0o777)
    for folder in (made, private_folder(opened)):
        assert folder is not None
        assert stat.S_IMODE(folder.stat().st_mode) == 0o700


def test_a_folder_of_somebody_else_is_not_used(
    tmp_path: Path, said: Callable[[], list[str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nor a link, which may lead there, nor a file: what lies there could run anything."""
    (tmp_path / "file").touch()
    (tmp_path / "link").symlink_to(tmp_path)
    for name in ("link", "file", "file/below"):
        assert private_folder(tmp_path / name) is None
    monkeypatch.setattr(kernel_cache.os, "geteuid", lambda: os.getuid() + 1)
    assert private_folder(tmp_path) is None
    assert len(said()) == 4
    assert f"belongs to user {os.getuid()}" in said()[-1]


def test_without_a_folder_everything_runs_in_memory(tmp_path: Path) -> None:
    """Where the home cannot be written, a new process compiles, and says so in one line."""
    (tmp_path / "home").touch()
    code = (
        "from rodless_base import kernels\n"
        "@kernels.kernel\ndef half(x):\n    return x / 2.0\n"
        "print(half(3.0))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={**unmeasured(), "NUMBA_CACHE_DIR": "", "XDG_CACHE_HOME": str(tmp_path / "home")},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout == "1.5\n"
    assert done.stderr.count("\n") == 1
    assert "compiled code is not kept, each start compiles anew" in done.stderr
