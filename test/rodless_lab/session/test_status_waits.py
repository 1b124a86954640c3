# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""How long `rodless status` waits for a rig of which a part says nothing."""

from collections.abc import Callable
from typing import Any, cast

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from sensor_msgs.msg import JointState

from rodless_base.constants import CARRIAGE
from rodless_base.topics import JOINT_STATES, PRESSURES
from rodless_lab.session.diagnostic import Diagnostic
from rodless_lab.session.running_rig import NODES, RunningRig
from rodless_lab.session.status import rig_status

TIMEOUT = 8.0


class Silent:
    """A rig of which only ``nodes`` report; what else they publish is as good as there at once."""

    namespace = "/"

    def __init__(self, *nodes: str, joint: str = CARRIAGE) -> None:
        self._nodes = nodes
        self._joint = joint
        self.waited: list[float] = []
        self.observer = self

    def subscribe(self, kind: Any, topic: str, take: Callable[[Any], None]) -> None:
        """Deliver what the plant publishes, where it is one of the nodes."""
        if "plant" in self._nodes and topic in (JOINT_STATES, *PRESSURES.values()):
            message = kind()
            if kind is JointState:
                message.name, message.position = [self._joint], [0.0]
            take(message)

    def diagnostic(self, node: str) -> Diagnostic | None:
        """Return a report of a node that reports."""
        said = Diagnostic(DiagnosticStatus.OK, "running", {"speed factor": "1.000"})
        return said if node in self._nodes else None

    def is_known(self, _node: str) -> bool:
        """What says nothing is not found either."""
        return False

    def samples_elsewhere(self) -> str | None:
        """Say where they are, whether they are missed or not."""
        return "samples are elsewhere"

    def doubles(self) -> list[str]:
        """Say of one that it is there twice."""
        return ["two plants"]

    def wait_for(self, condition: Callable[[], object], timeout: float) -> bool:
        """Wait as long as it takes, which is the whole timeout for what does not come."""
        if not condition():
            self.waited.append(timeout)
        return bool(condition())


@pytest.mark.parametrize("nodes", [("plant",), ()])
def test_what_only_a_missing_node_sends_is_not_waited_for(nodes: tuple[str, ...]) -> None:
    """One timeout for the reports is all: no reading of a node that has none comes after it."""
    rig = Silent(*nodes)
    status = rig_status(cast(RunningRig, rig), TIMEOUT)
    assert rig.waited == [TIMEOUT]
    levels = {node: "OK" if node in nodes else "missing" for node in NODES}
    assert {node: found.level for node, found in status.nodes.items()} == levels
    assert status.readings["voltage"] is status.readings["reference"] is None


def test_what_a_node_that_reports_sends_is_waited_for() -> None:
    """The controller's reference may be matched later than its report."""
    rig = Silent(*NODES)
    rig_status(cast(RunningRig, rig), TIMEOUT)
    assert len(rig.waited) == 1
    assert rig.waited[0] < TIMEOUT


@pytest.mark.parametrize(
    ("joint", "problems"),
    [(CARRIAGE, ("two plants",)), ("slide", ("two plants", "samples are elsewhere"))],
)
def test_samples_are_looked_for_elsewhere_where_they_do_not_come(
    joint: str, problems: tuple[str, ...]
) -> None:
    """As the last problem, and not of a rig whose position is known."""
    rig = Silent(*NODES, joint=joint)
    assert rig_status(cast(RunningRig, rig), TIMEOUT).problems == problems
