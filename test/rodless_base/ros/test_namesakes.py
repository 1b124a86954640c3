# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A node finds others of its full name and says so; other names and namespaces are none."""

from collections.abc import Iterator

import pytest
from diagnostic_msgs.msg import DiagnosticStatus

from rodless_base.ros.diagnostics import Diagnostics, judge
from rodless_base.ros.guarded_node import GuardedNode
from rodless_base.ros.namesakes import Namesakes
from rodless_lab.session.observer import Observer


def nodes(observer: Observer, *namespaces: str) -> list[GuardedNode]:
    """Make a node ``plant`` in each of ``namespaces``."""
    options = {"context": observer.context, "use_global_arguments": False}
    return [GuardedNode("plant", namespace=namespace, **options) for namespace in namespaces]


@pytest.fixture
def plant(observer: Observer) -> Iterator[GuardedNode]:
    """Run one ``plant`` in /here, and another one elsewhere."""
    here, there = nodes(observer, "here", "there")
    yield here
    here.destroy_node()
    there.destroy_node()


def test_a_namesake_is_counted_and_said_once(
    observer: Observer, plant: GuardedNode, capfd: pytest.CaptureFixture[str]
) -> None:
    """As long as it is there; one that comes back is said again."""
    namesakes = Namesakes(plant)
    namesakes.check()
    assert (namesakes.count, namesakes.problem) == (1, None)
    for _ in range(2):
        (twin,) = nodes(observer, "here")
        for _ in range(3):
            namesakes.check()
        assert namesakes.count == 2
        assert namesakes.problem is not None
        assert namesakes.problem.startswith("2 nodes named plant in namespace /here of ROS domain")
        twin.destroy_node()
        namesakes.check()
        assert (namesakes.count, namesakes.problem) == (1, None)
    assert capfd.readouterr().err.count("2 nodes named plant") == 2


def test_their_number_is_in_the_report(observer: Observer, plant: GuardedNode) -> None:
    """Counted when the report is made, for whoever has just joined."""
    diagnostics = Diagnostics(plant, lambda: {"faults": 3})
    reports = observer.diagnostics

    def reported() -> str | None:
        diagnostics.publish(1_500_000_000, (DiagnosticStatus.OK, "well"), diagnostics.count())
        return reports["/here/plant"].values["nodes of this name"] if reports else None

    assert observer.wait(reported, "a report") == "1"
    (twin,) = nodes(observer, "here")
    observer.wait(lambda: reported() == "2", "the namesake")
    twin.destroy_node()
    assert reports["/here/plant"].values["faults"] == "3"


@pytest.mark.parametrize(
    ("problem", "state", "warnings", "expected"),
    [
        (None, None, (None, None), (DiagnosticStatus.OK, "running")),
        (None, "paused", (None,), (DiagnosticStatus.OK, "paused")),
        (None, "paused", ("late", None, "lost"), (DiagnosticStatus.WARN, "paused; late; lost")),
        (None, None, ("late",), (DiagnosticStatus.WARN, "late")),
        ("no command", "paused", ("late",), (DiagnosticStatus.ERROR, "no command")),
    ],
)
def test_what_is_worst_makes_the_level(
    problem: str | None,
    state: str | None,
    warnings: tuple[str | None, ...],
    expected: tuple[bytes, str],
) -> None:
    """A problem hides all else; a state by request is no warning."""
    assert judge(problem, state, warnings, "running") == expected
