# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""How much of what takes minutes the tests do: a part of it, or all with RODLESS_EXTENSIVE=1."""

import os
from collections.abc import Sequence

import pytest

EXTENSIVE = os.environ.get("RODLESS_EXTENSIVE", "") not in ("", "0")


def draws(everything: int, part: int) -> int:
    """How often a test draws: ``part`` by ``make test``, ``everything`` by ``make test-extensive``.

    What is claimed is the same for both: a part finds the same faults, but rare ones less often.
    """
    return everything if EXTENSIVE else part


# For what takes long, and where another test of `make test` shows the same of another case.
extensive = pytest.mark.skipif(not EXTENSIVE, reason="takes long: make test-extensive")


def some_of(cases: Sequence[object], every: int) -> list[object]:
    """Of cases for ``parametrize`` each ``every``th, and the others where all is done."""
    return [case if number % every == 0 else also(case) for number, case in enumerate(cases)]


def also(*values: object) -> object:
    """Return a case for ``parametrize`` that is left to ``make test-extensive``."""
    return pytest.param(*values, marks=extensive)
