# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A pytest plugin: the fixture ``rig_session``, and the nodes' output below a failing test.

It has a package of its own so that pytest runs that use no rig load none of the others.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from rodless_lab.harness import RigSession

_SESSIONS = pytest.StashKey[list["RigSession"]]()


@pytest.fixture
def rig_session(
    request: pytest.FixtureRequest, tmp_path: Path
) -> Iterator[Callable[..., RigSession]]:
    """Return a function that starts a rig and returns it; it ends with the test.

    It takes the options of ``rodless_lab.harness.RigSession``; several sessions at a time do not
    hear each other. What the nodes print is in ``rig0``, ``rig1``, … of the test's ``tmp_path``.
    """
    from rodless_lab.harness import RigSession  # noqa: PLC0415  loads ROS

    # A test that is run again, as by pytest-rerunfailures, has none of its try before.
    sessions = request.node.stash[_SESSIONS] = list["RigSession"]()
    with ExitStack() as stack:

        def start(*arguments: Any, **options: Any) -> RigSession:
            options.setdefault("output", tmp_path / f"rig{len(sessions)}")
            session = RigSession(*arguments, **options)
            sessions.append(session)
            return stack.enter_context(session)

        yield start


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item,
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Show with a failing test what the nodes of its sessions have printed."""
    report = yield
    if report.failed:
        sessions: list[RigSession] = item.stash.setdefault(_SESSIONS, [])
        for number, session in enumerate(sessions):
            report.sections += [
                (f"output of rig {number}: {name}", text) for name, text in session.outputs.items()
            ]
    return report
