# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A rig that never becomes ready says why, instead of nothing."""

from itertools import count
from types import SimpleNamespace

import pytest

from rodless_lab.session import readiness
from rodless_lab.session.processes import ProcessPlan


def test_nodes_that_are_never_found_are_told_of(
    domain: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """As where the environment keeps them from finding each other: after a while, once."""
    for name, value in domain.items():
        monkeypatch.setenv(name, value)
    now = count(0.0, 0.1 * readiness.COMPILING_SECONDS)
    monkeypatch.setattr(readiness, "monotonic", lambda: next(now))
    said: list[str] = []
    looks = iter([False] * 30)
    readiness.say_when_ready(
        ProcessPlan(),
        SimpleNamespace(requested=False),  # type: ignore[arg-type]
        lambda: next(looks, True),
        said.append,
    )
    assert len(said) == 1
    assert said[0].startswith("not ready: /plant: not found: it compiles for its first start, or")
    assert "/controller: not found" in said[0]
