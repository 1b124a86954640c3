# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Where compiled kernels are kept between processes, and what happens when that fails.

numba keeps compiled code as pickles, which run what is in them: the folder is the user's alone, and
each file carries a checksum. Whatever is wrong with the cache, kernels are compiled anew and kept
in memory; one line says so.
"""

import errno
import fcntl
import hashlib
import logging
import os
import pickle
import stat
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any

from numba.core import caching
from numba.core.caching import CompileResultCacheImpl, FunctionCache, IndexDataCacheFile
from numba.core.sigutils import normalize_signature

from rodless_base.one_line import in_one_line
from rodless_base.regular_file import NotAFileError, open_file, read_file

# Ubuntu 24.04 has numba 0.58, where the name begins with an underscore.
LOCATOR: Any = vars(caching).get("UserProvidedCacheLocator") or caching._UserProvidedCacheLocator

LOGGER = logging.getLogger("rodless_sim")

COMPILING = "compiling, which takes about a minute"
NOT_KEPT = "compiled code is not kept, each start compiles anew"
UNREADABLE = "compiled code cannot be read, compiling anew"

# What rebuilds a class that cannot be imported: whoever reads it has another class of that name.
BY_VALUE = b"_make_skeleton_class"

CHECKSUM_BYTES = hashlib.sha256().digest_size

# In the folder of compiled code, locked by whoever writes there.
LOCK = "being_written.lock"
# How long to wait for that, in s; to write takes some ms. Once in vain, then no more.
PATIENCE = [5.0]


def private_folder(path: Path) -> Path | None:
    """Make the folder ``path`` for this user alone; return None, and say so, where it cannot be."""
    try:
        path.mkdir(mode=0o700, parents=True, exist_ok=True)
        found = path.lstat()
        if not stat.S_ISDIR(found.st_mode):
            raise PermissionError(f"{path} is no folder")
        if found.st_uid != os.geteuid():
            raise PermissionError(f"{path} belongs to user {found.st_uid}")
        if stat.S_IMODE(found.st_mode) != stat.S_IRWXU:
            path.chmod(stat.S_IRWXU)
    except OSError as error:
        complain(f"{NOT_KEPT}: {error}")
        return None
    return path


@cache
def complain(line: str) -> None:
    """Say ``line`` once."""
    LOGGER.warning(line)


@cache
def announce() -> None:
    """Say once that this process has to compile: without logging set up, too."""
    line = f"{COMPILING}; the next start finds the result"
    if LOGGER.hasHandlers() and LOGGER.isEnabledFor(logging.INFO):
        LOGGER.info(line)
    else:
        print(line, file=sys.stderr, flush=True)


class _Locator(LOCATOR):  # type: ignore[misc]
    """numba's, but for a folder that cannot be written: what it holds is used all the same."""

    def ensure_cache_path(self) -> None:
        Path(self.get_cache_path()).mkdir(mode=0o700, parents=True, exist_ok=True)


class _CompileResults(CompileResultCacheImpl):  # type: ignore[misc]
    """numba's, in the folder that it is given and nowhere else."""

    _locator_classes = (_Locator,)


@contextmanager
def _locked(folder: Path) -> Iterator[None]:
    """Keep others from writing to ``folder``; raises OSError for one that cannot be written.

    On shared file systems without locks nobody is kept out, nor for long by a process that stands.
    """
    descriptor = open_file(folder / LOCK, os.O_RDWR | os.O_CREAT)
    try:
        with suppress(OSError):
            _lock(descriptor)
        yield
    finally:
        with suppress(OSError):  # closing alone keeps it, where a process was forked meanwhile
            fcntl.flock(descriptor, fcntl.LOCK_UN)
        os.close(descriptor)


def _lock(descriptor: int) -> None:
    """Lock a file, or raise OSError: where there are no locks, or it stays another's."""
    until = time.monotonic() + PATIENCE[0]
    while True:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if time.monotonic() > until:
                PATIENCE[0] = 0.0
                raise
            time.sleep(0.01)
        else:
            return


def _key(dumped: bytes) -> object:
    """Return a key of an index; one of a class that this process lacks stays as it is."""
    try:
        found: object = pickle.loads(dumped)
    except Exception:
        return dumped
    return found


class _CheckedFiles(IndexDataCacheFile):  # type: ignore[misc]
    """numba's two files, with a checksum before the content; a damaged one is none.

    In the index each key is a pickle by itself: one that only other processes can read stays there.
    """

    def _load_index(self) -> dict[Any, str]:
        content = self._read(self._index_path)
        if content is None:
            return {}
        try:
            version, stamp, names = pickle.loads(content)
            fresh = (version, stamp) == (self._version, self._source_stamp)
            return {_key(dumped): name for dumped, name in names} if fresh else {}
        except Exception as error:
            text = f"{type(error).__name__}: {error}: {self._index_path}"
            complain(f"{UNREADABLE}: {in_one_line(text)}")
            return {}

    def holds(self, key: object) -> bool:
        """Whether there is a file for a version by its ``key``."""
        name = self._load_index().get(key)
        return name is not None and Path(self._data_path(name)).is_file()

    def _save_index(self, overloads: dict[Any, str]) -> None:
        names = [
            (key if isinstance(key, bytes) else self._dump(key), name)
            for key, name in overloads.items()
        ]
        self._write(self._index_path, (self._version, self._source_stamp, names))

    def _load_data(self, name: str) -> object:
        content = self._read(self._data_path(name))
        if content is None:
            raise FileNotFoundError  # which load() expects
        return pickle.loads(content)

    def _save_data(self, name: str, data: object) -> None:
        self._write(self._data_path(name), data)

    def _write(self, path: str, value: object) -> None:
        content = self._dump(value)
        if BY_VALUE in content:
            raise OSError(
                errno.ESTALE,
                "a class in it cannot be imported: it was made in a script or notebook, or its "
                "module was reloaded",
            )
        with self._open_for_write(path) as file:
            file.write(hashlib.sha256(content).digest() + content)

    @staticmethod
    def _read(path: str) -> bytes | None:
        try:
            whole = read_file(Path(path))
        except FileNotFoundError:
            return None
        except NotAFileError as error:
            complain(f"{error.strerror}, in place of compiled code, compiling anew: {path}")
            return None
        checksum, content = whole[:CHECKSUM_BYTES], whole[CHECKSUM_BYTES:]
        if hashlib.sha256(content).digest() != checksum:
            complain(f"a file of compiled code is damaged, compiling anew: {path}")
            return None
        return content


class KernelCache(FunctionCache):  # type: ignore[misc]
    """The compiled forms of one kernel; never the reason why it cannot be had."""

    _impl_class = _CompileResults

    def __init__(self, function: object, form: str = "") -> None:
        """Look in numba's ``config.CACHE_DIR``; raises RuntimeError or OSError if it cannot.

        The forms of one function do not take each other's place.
        """
        super().__init__(function)
        self._cache_file = _CheckedFiles(
            self._cache_path, self._impl.filename_base + form, self._impl.locator.get_source_stamp()
        )

    def holds(self, signature: object, target: Any) -> bool:
        """Whether there is something for ``signature``, which loading may still find damaged."""
        try:
            return self._cache_file.holds(self._index_key(signature, target.codegen()))
        except Exception:
            return False

    def load_overload(self, signature: object, target: object) -> object:
        """Return what was compiled for ``signature``, or None."""
        found: Any = None
        try:
            found = super().load_overload(signature, target)
            # Without locks two processes that save at once may leave one file for two keys.
            if found is not None and found.signature.args != normalize_signature(signature)[0]:
                found = None
        except Exception as error:
            text = f"{type(error).__name__}: {error}"
            complain(f"{UNREADABLE}: {in_one_line(text)}")
        if found is None:
            announce()
        return found

    def save_overload(self, signature: object, compiled: object) -> None:
        """Keep ``compiled`` if that is possible."""
        try:
            self._impl.locator.ensure_cache_path()
            with _locked(Path(self._cache_path)):
                super().save_overload(signature, compiled)
        except Exception as error:
            reason = getattr(error, "strerror", None) or f"{type(error).__name__}: {error}"
            complain(
                "compiled code cannot be kept, the next start compiles anew: "
                f"{in_one_line(reason)}: {self._cache_path}"
            )
