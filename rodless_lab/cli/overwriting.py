# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""That no result takes the place of what it is made from."""

import errno
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from types import MappingProxyType

from rodless_base.atomic_write import check_file_writable
from rodless_lab.bags.metadata import COMPRESSED, METADATA_FILE, STORAGES

_NONE: Mapping[Path, str] = MappingProxyType({})


def check_none_is_read(written: Iterable[Path], read: Mapping[Path, str] = _NONE) -> None:
    """Raise OSError where a result would go in place of a file that is read, or is called as a bag.

    ``read`` says what each file is read as. Links are followed, as they are where it is written. A
    bag is what has the name of one, whether it is there or not: a storage file that holds something
    else makes the bag in its folder unreadable.
    """
    for file in written:
        real = Path(os.path.realpath(file))
        if real.name == METADATA_FILE or real.suffix in (*STORAGES, COMPRESSED):
            raise _refusal(file, "it has the name of a file of a bag")
        for other, what in read.items():
            if _is_same(real, other):
                raise _refusal(file, f"it is read as {what}")


def check_result_file(file: Path) -> None:
    """Raise OSError where a file of results cannot be written, or has the name of a bag's."""
    check_none_is_read([file])
    check_file_writable(file)


def _refusal(file: Path, cause: str) -> OSError:
    return OSError(errno.EINVAL, f"{cause}; give another --output", str(file))


def _is_same(one: Path, other: Path) -> bool:
    try:
        return one.samefile(other)
    except OSError:  # one of them is not there
        return False
