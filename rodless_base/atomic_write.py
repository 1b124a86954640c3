# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Files that are there whole or not at all."""

import errno
import os
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

# Files beside the places that they are to take.
_unfinished: set[Path] = set()


def atomic_write(path: Path, content: str | bytes) -> None:
    """Write ``content`` to ``path`` whole or not at all; raises OSError, which names it.

    Where ``path`` is a symbolic link, its target is written and the link stays. A device, pipe or
    socket stays what it is: that is refused.
    """
    write_together({path: content})


def write_together(contents: Mapping[Path, str | bytes]) -> None:
    """Write files that belong together as :func:`atomic_write`: where one cannot be, none is.

    All are complete before the first of them takes its place, the last one of all at last. Folders
    are made for them; those are gone again where the files cannot be written.
    """
    beside: list[tuple[Path, Path]] = []
    undo = []
    try:
        for path, content in contents.items():
            target = Path(os.path.realpath(path))
            with naming(target):
                _refuse_other_than_a_file(target)
                undo.append(removal_of_new(target.parent))
                target.parent.mkdir(parents=True, exist_ok=True)
                beside.append((_written_beside(target, content), target))
        for unfinished, target in beside:
            with naming(target):
                unfinished.replace(target)
    finally:
        for unfinished, _ in beside:
            _remove(unfinished)
        for remove in undo:
            remove()


def removal_of_new(folder: Path) -> Callable[[], None]:
    """Return what removes ``folder`` and those above it again, where they are new and empty."""
    new = [place for place in (folder, *folder.parents) if not place.exists()]

    def remove_what_is_empty() -> None:
        with suppress(OSError):  # one that holds something
            for place in new:
                place.rmdir()

    return remove_what_is_empty


@contextmanager
def naming(path: Path) -> Iterator[None]:
    """Let an OSError name ``path``: not a part of it, and not none, as where the disk is full."""
    try:
        yield
    except OSError as error:
        if error.errno is None:
            raise
        raise OSError(error.errno, error.strerror, str(path)) from error


def _written_beside(path: Path, content: str | bytes) -> Path:
    """Return a new file beside ``path`` with ``content``, on the disk."""
    handle, name = tempfile.mkstemp(prefix=f".{path.name[:40]}.", dir=path.parent)
    unfinished = Path(name)
    _unfinished.add(unfinished)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content.encode() if isinstance(content, str) else content)
            # mkstemp lets nobody else read the file; the result is for everybody, as any other.
            os.fchmod(file.fileno(), 0o666 & ~_mask())
            file.flush()
            os.fsync(file.fileno())
    except BaseException:
        _remove(unfinished)
        raise
    return unfinished


def _remove(unfinished: Path) -> None:
    unfinished.unlink(missing_ok=True)
    _unfinished.discard(unfinished)


def remove_unfinished() -> None:
    """Remove what is written at the moment: for a process that ends on the spot."""
    for unfinished in tuple(_unfinished):
        with suppress(OSError):
            unfinished.unlink(missing_ok=True)


def _refuse_other_than_a_file(path: Path) -> None:
    """Raise OSError for what is there and no file: the new one would take its place."""
    if path.is_symlink():  # of a resolved path: links in a circle
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), str(path))
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if path.exists() and not path.is_file():
        raise OSError(errno.EINVAL, "is no regular file", str(path))


def check_writable(folder: Path) -> None:
    """Raise OSError now rather than after minutes of work; ``folder`` need not be there yet.

    A full disk takes one more empty file, so a page is written too.
    """
    # A link that leads nowhere is there as well: no folder can be made in its place.
    there = next(place for place in (folder, *folder.parents) if os.path.lexists(place))
    with naming(folder), tempfile.TemporaryFile(dir=there) as probe:
        probe.write(bytes(4096))


def make_folder(folder: Path) -> None:
    """Make a folder for results, with those above it, where it can be written; raises OSError.

    Nothing is made where it cannot.
    """
    check_writable(folder)
    folder.mkdir(parents=True, exist_ok=True)


def check_file_writable(file: Path) -> None:
    """Raise OSError as :func:`check_writable`, for a file that is to be written."""
    target = Path(os.path.realpath(file))
    with naming(file):
        _refuse_other_than_a_file(target)
        check_writable(target.parent)


def check_files_writable(files: Iterable[Path]) -> None:
    """Raise OSError as :func:`check_file_writable`, for the first of ``files`` that cannot be."""
    for file in files:
        check_file_writable(file)


def cannot_be_written(what: object, error: OSError) -> str:
    """Return the line that says so of ``what``, with the cause."""
    return f"{what}: cannot be written: {error.strerror or error}"


def named_or_as_it_is(error: OSError) -> str:
    """Return :func:`cannot_be_written` of the file that the error names; its text without one."""
    named = error.filename is not None and error.strerror
    return cannot_be_written(error.filename, error) if named else str(error)


def _mask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
