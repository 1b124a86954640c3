# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What pages show of nodes that say anything."""

from types import SimpleNamespace
from typing import Any

import pytest
from rcl_interfaces.msg import Parameter, ParameterEvent, ParameterValue
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from rodless_base.constants import SPOOL
from rodless_base.topics import VALVE_STATE, VALVE_VOLTAGE
from rodless_lab.session.errors import HarnessError
from rodless_lab.view.ros.desk import Desk
from rodless_lab.view.ros.live import LiveRig
from rodless_lab.view.samples import COLUMNS, Row, spool_of, value
from rodless_lab.view.state import CONTROLLER, PLANT, NodeState, ViewState


@pytest.mark.parametrize(
    ("text", "factor"),
    [("0.97", 0.97), ("fast", None), ("", None), ("nan", None), ("1e999", None)],
)
def test_a_speed_that_is_no_number_is_not_shown(text: str, factor: float | None) -> None:
    """A plant of another make may say it in words."""
    state = ViewState()
    assert state.speed_factor is None
    state.nodes[PLANT] = NodeState("OK", "running", {"speed factor": text})
    assert state.speed_factor == factor


@pytest.mark.parametrize(
    ("message", "said", "enabled"),
    [
        ("controlling", "True", True),
        ("disabled: valve closed", "False", False),
        ("no position: valve closed", "False", False),
        ("no position: valve closed", "True", True),
        ("law pid failed: nan; valve closed until ~/reset or ~/enable", "True", False),
    ],
)
def test_whether_a_controller_is_to_be_enabled_is_told_apart_from_its_problems(
    message: str, said: str, enabled: bool
) -> None:
    """A problem takes the place of the words; a law that has failed goes on once enabled anew."""
    state = ViewState()
    state.nodes[CONTROLLER] = NodeState("ERROR", message, {"enabled": said})
    assert state.enabled is enabled


def test_a_page_says_what_it_waits_for() -> None:
    """Until readings come the page says so; a problem comes first; without a rig none are due."""
    state = ViewState("/rig1")
    assert state.notice is not None
    assert state.notice.startswith("waiting for a plant in /rig1")
    state.unheard = "/joint_states: published, but nothing arrives"
    assert state.notice == state.unheard
    state.problem = "readings have ended"
    assert state.notice == "readings have ended"
    state.problem = None
    assert state.history.add([0.0] * len(COLUMNS))
    assert state.notice is None
    assert ViewState(live=False).notice is None


class Topics(LiveRig):
    """Reads what a test says; of a node it has who publishes what."""

    def __init__(self, state: ViewState, *published: str) -> None:
        self._state: Any = state
        self._values, self._terms, self._takers = {}, (), {}
        self._stamp: int | None = 0
        self.published = list(published)
        self._node: Any = SimpleNamespace(
            count_publishers=self.published.count,
            resolve_topic_name="/{}".format,
            get_topic_names_and_types=list,
        )

    def _subscribe(self, kind: type, topic: str, take: Any) -> None:
        subscription: Any = SimpleNamespace(topic_name=f"/{self._source(topic)}", msg_type=kind)
        self._takers[topic] = subscription, take

    def _unsubscribe(self, topic: str) -> None:
        del self._takers[topic]

    def row(self) -> Row:
        """Look for publishers, and return the row then."""
        self._discover()
        self._stamp = (self._stamp or 0) + 10**9
        self._add_row()
        assert self._state.history.last is not None
        return self._state.history.last


@pytest.mark.ros
def test_a_spool_is_where_the_command_is_once_no_plant_says_where() -> None:
    """A plant ends, and a real rig whose valve tells nothing goes on: it stayed where it was."""
    topics = Topics(ViewState(), VALVE_STATE)
    topics._take_valve(JointState(name=[SPOOL], position=[1e-4], effort=[7.0]))
    row = topics.row()
    assert value(row, "spool") not in (None, 7.0)
    topics.published[:] = [VALVE_VOLTAGE]
    topics._discover()
    topics._takers[VALVE_VOLTAGE][1](Float64(data=3.0))
    assert spool_of(topics.row()) == 3.0


@pytest.mark.ros
def test_a_parameter_of_a_type_that_is_none_has_no_value() -> None:
    """Whoever publishes parameter events: it does not end the view."""
    state = ViewState()
    callbacks: list[Any] = []
    observer = SimpleNamespace(subscribe=lambda _kind, _topic, callback: callbacks.append(callback))
    Desk(SimpleNamespace(observer=observer, name="/{}".format), state)  # type: ignore[arg-type]
    odd = Parameter(name="odd", value=ParameterValue(type=77))
    good = Parameter(name="good", value=ParameterValue(type=3, double_value=0.5))
    (take,) = callbacks
    take(ParameterEvent(node="/plant", changed_parameters=[odd, good]))
    assert state.parameters[PLANT] == {"odd": None, "good": 0.5}


@pytest.mark.ros
def test_parameters_that_were_not_told_are_asked_for_again_with_the_next_report() -> None:
    """Not before it, and not once they are known; the page says meanwhile what it lacks."""
    state, asked = ViewState(), list[str]()
    reports = {PLANT: report(1.0)}

    def told(node: str, _names: list[str]) -> dict[str, object]:
        asked.append(node)
        if len(asked) == 1:
            raise HarnessError("no answer within 5 s")
        return {"supply.pressure": 6e5}

    observer = SimpleNamespace(
        subscribe=lambda *_: None,
        spin=lambda _seconds: None,
        parameter_names=lambda _node: ["supply.pressure"],
        get_parameters=told,
    )
    rig = SimpleNamespace(
        observer=observer,
        diagnostic=reports.get,
        is_silent=lambda _node: False,
        is_known=lambda _node: False,
    )
    desk = Desk(rig, state)  # type: ignore[arg-type]
    unknown = "plant: its parameters are not known: no answer within 5 s"

    rounds(desk, 3)
    assert (asked, state.problem) == ([PLANT], unknown)
    for arrived in (2.0, 3.0):
        reports[PLANT] = report(arrived)
        rounds(desk, 3)
        assert (asked, state.problem) == ([PLANT] * 2, None)
    assert state.parameters[PLANT] == {"supply.pressure": 6e5}


def report(arrived: float) -> SimpleNamespace:
    """What a node says that runs."""
    return SimpleNamespace(arrived=arrived, level=0, message="running", values={})


def rounds(desk: Desk, count: int) -> None:
    """Let the desk go round so often."""
    stop = SimpleNamespace(requested=False)
    left = iter([False] * (count - 1))

    def check() -> None:
        stop.requested = next(left, True)

    desk.serve(stop, check)  # type: ignore[arg-type]
