# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A disk that is full, as far as this process can tell."""

import contextlib
import errno
import os
import resource
from collections.abc import Iterator

import pytest


@contextlib.contextmanager
def no_room() -> Iterator[None]:
    """Let no file grow: as on a full disk one can still be made, and so can a folder."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def fill_up(monkeypatch: pytest.MonkeyPatch, room: int = 0) -> None:
    """Let the disk be full when a file is to be finished, and not before; ``room`` files are."""
    left = iter(range(room))

    def full(_descriptor: int) -> None:
        if next(left, None) is None:
            raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
