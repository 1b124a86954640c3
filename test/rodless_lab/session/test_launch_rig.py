# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A rig whose processes launch starts, with a stand-in for launch where that is not installed."""

import os
import subprocess
import sys
from collections.abc import Iterator
from types import SimpleNamespace

import pytest

from rodless_lab.harness import HarnessError, NodeDiedError
from rodless_lab.session.launch_rig import LaunchedRig

pytestmark = pytest.mark.usefixtures("compiled")

# For a process of a test to end, in wall-clock s.
TIMEOUT = 500.0


class StandInProcess:
    """Takes what launch's ExecuteProcess takes, and runs it."""

    def __init__(
        self, *, cmd: list[str], name: str, additional_env: dict[str, str], output: str
    ) -> None:
        assert output == "both"
        self.name = name
        self._process = subprocess.Popen(
            cmd, env={**os.environ, **additional_env}, stdout=subprocess.DEVNULL
        )

    @property
    def return_code(self) -> int | None:
        """As launch has it."""
        return self._process.poll()

    def end(self) -> int:
        """End it as launch does."""
        self._process.terminate()
        return self._process.wait(TIMEOUT)


@pytest.fixture
def rig(monkeypatch: pytest.MonkeyPatch) -> Iterator[LaunchedRig]:
    """Return a short lock-step run, its processes started."""
    stand_in = SimpleNamespace(ExecuteProcess=StandInProcess)
    monkeypatch.setitem(sys.modules, "launch", SimpleNamespace(actions=stand_in))
    monkeypatch.setitem(sys.modules, "launch.actions", stand_in)
    rig = LaunchedRig("lockstep", duration=0.2)
    assert [action.name for action in rig.actions] == ["plant", "controller"]
    yield rig
    for action in rig.actions:
        action.end()


def test_a_launched_rig_is_a_session_that_leaves_its_processes_alone(rig: LaunchedRig) -> None:
    """The test hears every sample; the processes run on after the block, launch's to end.

    A second block would begin in the middle of the run.
    """
    with rig as same:
        assert same is rig
        assert len(rig.run()) == 201
        with pytest.raises(HarnessError, match="belongs to launch"):
            rig.kill("plant")
    assert [action.return_code for action in rig.actions] == [None, None]
    with pytest.raises(HarnessError, match="the run of a LaunchedRig is that of its first with"):
        rig.__enter__()
    assert [action.end() for action in rig.actions] == [0, 0]


def test_a_launched_node_that_has_ended_fails_the_test(rig: LaunchedRig) -> None:
    """Entering the block says so at once."""
    rig.actions[0].end()
    with pytest.raises(NodeDiedError, match="plant has ended with exit code"):
        rig.__enter__()
