# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What of the package compiles functions, copied: sources that a test may change."""

import shutil
from pathlib import Path

from rodless_base import kernels

FILES = (
    "__init__.py",
    "boxing.py",
    "kernels.py",
    "kernel_cache.py",
    "one_line.py",
    "regular_file.py",
)


def copy_kernels(folder: Path) -> None:
    """Make the package ``rodless_base`` in ``folder``, with nothing else in it."""
    (folder / "rodless_base").mkdir()
    for name in FILES:
        shutil.copy(Path(kernels.__file__).parent / name, folder / "rodless_base")
