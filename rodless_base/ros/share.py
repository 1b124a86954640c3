# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Where ROS packages keep their files, with a ROS distribution sourced or from wheels."""

import importlib.util
import os
from collections.abc import Iterator
from pathlib import Path


def share_directories(package: str, beside: str = "") -> Iterator[Path]:
    """Yield where the files of ``package`` may be, the one its Python module belongs to first.

    Wheels of ROS set no AMENT_PREFIX_PATH, so the module's own prefix is looked for above it; for
    a package without a module, above that of the package ``beside`` it.
    """
    module = importlib.util.find_spec(beside or package)
    if module is not None and module.origin is not None:
        for parent in Path(module.origin).parents:
            yield parent / "share" / package
    for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        if prefix:
            yield Path(prefix) / "share" / package
