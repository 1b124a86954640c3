# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Which version of the rules has made a result: rows and scores of two are not put together."""

import hashlib
from collections.abc import Iterable
from functools import cache
from pathlib import Path

from rodless_base.kernels import source_digest
from rodless_control.controller_parameters import ControllerParameters

SIMULATION = Path(__file__).parents[1] / "simulation"

# Beside what kernels depend on: what draws the rigs, runs them and judges their runs.
_RULES = (Path(__file__).parent, SIMULATION)


@cache
def sources_digest(*places: Path) -> str:
    """Return a digest of what kernels depend on and of the sources at ``places``.

    A place is a file, or a folder of which all files count.
    """
    digest = hashlib.sha256(source_digest().encode())
    for place in places:
        for file in sorted(place.glob("*.py")) if place.is_dir() else (place,):
            digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


def rules_digest() -> str:
    """Return a digest of all sources of this package that a row or a score depends on."""
    return sources_digest(*_RULES)


def law_digests(controllers: Iterable[ControllerParameters]) -> list[str]:
    """Return the digest of the file of each controller's law, which may be a user's, in order."""
    return [one.LAW_CLASS.SOURCE_DIGEST for one in controllers]
