# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What pages may ask for, without a rig: what is sent, and what is refused."""

import asyncio
import errno
import os
import subprocess
import tempfile
from collections.abc import Mapping
from concurrent.futures import Future
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest
import rig_bag

from rodless_control import ControllerParameters
from rodless_lab.runs.measured_run import MeasuredRun
from rodless_lab.view import frames
from rodless_lab.view.errors import ViewError
from rodless_lab.view.requests import Requests
from rodless_lab.view.samples import Mark
from rodless_lab.view.state import ViewState
from rodless_sim import RigParameters


class Rig:
    """Takes what is asked for, and does it to the state as nodes would."""

    def __init__(self, state: ViewState) -> None:
        self.state = state
        self.asked: list[object] = []
        self.refusal: str | None = None

    def send_set_point(self, target: float) -> None:
        """Take one."""
        self.asked.append(target)

    def set_parameters(self, given: Mapping[str, str]) -> "Future[None]":
        """Take all."""
        self.asked.append(dict(given))
        values = {name: float(text) for name, text in given.items() if name == "supply.pressure"}
        return self._answer(lambda: self.state.take_parameters("plant", values))

    def call(self, services: Mapping[str, bool | None], times: int = 1) -> "Future[None]":
        """Take note."""
        self.asked.append((dict(services), times))
        return self._answer(lambda: None)

    def _answer(self, work: object) -> "Future[None]":
        answer: Future[None] = Future()
        if self.refusal is None:
            work()  # type: ignore[operator]
            answer.set_result(None)
        else:
            answer.set_exception(ViewError(self.refusal))
        return answer


@pytest.fixture
def state() -> ViewState:
    state = ViewState()
    state.take_parameters("plant", dict(RigParameters()), whole=True)
    state.take_parameters("controller", dict(ControllerParameters()), whole=True)
    return state


@pytest.fixture
def rig(state: ViewState) -> Rig:
    return Rig(state)


@pytest.fixture
def requests(state: ViewState, rig: Rig, tmp_path: Path) -> Requests:
    return Requests(state, tmp_path, rig, rig)


def test_a_set_point_is_sent_once_it_is_checked(requests: Requests, rig: Rig) -> None:
    """What is refused is not sent."""
    requests.set_point(0.058)
    with pytest.raises(ViewError, match="200 mm"):
        requests.set_point(0.3)
    assert rig.asked == [0.058]


def test_the_supply_is_cut_and_gets_back_the_pressure_it_had(
    requests: Requests, rig: Rig, state: ViewState
) -> None:
    """Cut means the pressure of the atmosphere; whatever it was before comes back."""
    state.take_parameters("plant", {"supply.pressure": 5.5e5})
    asyncio.run(requests.cut_supply(True))
    assert requests.supply_is_cut
    asyncio.run(requests.cut_supply(False))
    assert not requests.supply_is_cut
    ambient = RigParameters()["atmosphere.pressure"]
    assert rig.asked == [{"supply.pressure": f"{ambient}"}, {"supply.pressure": "550000.0"}]


def test_a_supply_that_others_have_cut_is_not_restored_by_guessing(
    requests: Requests, rig: Rig, state: ViewState
) -> None:
    """Nobody here knows what it was."""
    state.take_parameters("plant", {"supply.pressure": 1e5})
    with pytest.raises(ViewError, match="not cut here"):
        asyncio.run(requests.cut_supply(False))
    assert rig.asked == []


def test_a_supply_comes_back_to_the_rig_that_lost_it_alone(
    requests: Requests, rig: Rig, state: ViewState
) -> None:
    """After a reset it does; not to another rig, nor twice."""
    state.take_parameters("plant", {"supply.pressure": 5.5e5})
    for end_run in (requests.reset, None):
        asyncio.run(requests.cut_supply(True))
        if end_run is not None:
            asyncio.run(end_run())
        state.history.clear()  # as where the law has other terms: no other rig
        state.history.add((2.0, 0.0))
        state.history.add((1.0, 0.0))  # time goes back
        if end_run is not None:
            asyncio.run(requests.cut_supply(False))
            assert rig.asked[-1] == {"supply.pressure": "550000.0"}
    asked = len(rig.asked)
    with pytest.raises(ViewError, match=r"of this rig was not cut here; set supply\.pressure"):
        asyncio.run(requests.cut_supply(False))
    assert len(rig.asked) == asked


def test_a_step_begins_a_moment_from_now(requests: Requests, rig: Rig, state: ViewState) -> None:
    """All of it as one change: type, shape and start in plant time."""
    state.history.add((12.25, 0.0))
    asyncio.run(requests.set_reference("step", {"reference.target": 0.1}))
    asyncio.run(requests.set_reference("move", {"reference.velocity": 0.05}))
    assert rig.asked == [
        {"reference.type": "step", "reference.target": "0.1", "reference.at": "12.75"},
        {"reference.type": "move", "reference.velocity": "0.05"},
    ]
    with pytest.raises(ViewError, match="must be setpoint, ramp, move, step, sine"):
        asyncio.run(requests.set_reference("jump", {}))


def test_services_are_those_of_the_verbs(requests: Requests, rig: Rig) -> None:
    """As `rodless pause`, `reset`, `disable` call them."""
    for request in (requests.pause(True), requests.step(10), requests.reset()):
        asyncio.run(request)
    asyncio.run(requests.enable(False))
    assert rig.asked == [
        ({"plant/pause": True}, 1),
        ({"plant/step": None}, 10),
        ({"controller/reset": None, "plant/reset": None}, 1),
        ({"controller/enable": False}, 1),
    ]


def test_what_a_node_refuses_is_said_in_its_words(requests: Requests, rig: Rig) -> None:
    """The page shows them."""
    rig.refusal = "plant: supply.pressure: -1 refused"
    with pytest.raises(ViewError, match=r"supply\.pressure: -1 refused"):
        asyncio.run(requests.set({"supply.pressure": -1.0}))


def test_a_view_of_bags_alone_has_no_rig(tmp_path: Path) -> None:
    """Nothing to steer, and it says so."""
    requests = Requests(ViewState(live=False), tmp_path, None, None)
    for request in (requests.pause(True), requests.record(), requests.set({"a": 1.0})):
        with pytest.raises(ViewError, match="bags alone"):
            asyncio.run(request)
    with pytest.raises(ViewError, match="bags alone"):
        requests.close_bags()
    with pytest.raises(ViewError, match="bags alone"):
        requests.set_point(0.1)
    with pytest.raises(ViewError, match="no bag is open"):
        requests.play(True)


def test_bags_are_those_of_the_folder(requests: Requests, tmp_path: Path) -> None:
    """A page cannot name another; what exists is never written over."""
    (tmp_path / "run1").mkdir()
    (tmp_path / "run1" / "metadata.yaml").touch()
    (tmp_path / "other").mkdir()
    assert requests.bags == ["run1"]
    with pytest.raises(ViewError, match="exists already"):
        asyncio.run(requests.record("run1"))
    for names in (["../run1"], ["a", "b", "c"], [], "run1", None, [5], [np.array([])]):
        with pytest.raises(ViewError):
            asyncio.run(requests.open_bags(names))
    with pytest.raises(ViewError, match="nothing is being recorded"):
        asyncio.run(requests.stop_recording())


def test_what_is_listed_can_be_opened_whatever_its_name(requests: Requests, tmp_path: Path) -> None:
    """A new bag has a plainer one."""
    names = ["run 1", "läuft"]
    still = np.full(100, 4e5)
    run = MeasuredRun(1e-3 * np.arange(100), still / 4e6, still, still, still, still / 1e5)
    for name in names:
        rig_bag.write(tmp_path / name, run)
    asyncio.run(requests.open_bags(names))
    assert requests.state.playback is not None


def test_a_folder_that_may_not_be_entered_hides_no_bag(
    requests: Requests, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As those of others in /tmp; the bags are there, the latest first."""
    for number, name in enumerate(("first", "second", "barred")):
        (tmp_path / name).mkdir()
        (tmp_path / name / "metadata.yaml").touch()
        os.utime(tmp_path / name / "metadata.yaml", (number, number))
    find = Path.stat

    def look(path: Path, **options: bool) -> os.stat_result:
        if path.parent.name == "barred":
            raise PermissionError(errno.EACCES, "Permission denied", str(path))
        return find(path, **options)

    monkeypatch.setattr(Path, "stat", look)
    assert requests.bags == ["second", "first"]


def test_a_recorder_that_cannot_be_started_is_told(
    requests: Requests, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where /tmp is gone or full, or no process can be had; the page can record later."""
    with monkeypatch.context() as patch:
        patch.setattr(tempfile, "tempdir", str(tmp_path / "gone"))
        with pytest.raises(ViewError, match=r"^run1: .*/gone/.* cannot be written: No such file"):
            asyncio.run(requests.record("run1"))
    full = BlockingIOError(errno.EAGAIN, "Resource temporarily unavailable")
    with monkeypatch.context() as patch:
        patch.setattr(subprocess, "Popen", Mock(side_effect=full))
        with pytest.raises(ViewError, match=r"^run1: recorder: .* cannot be started: Resource"):
            asyncio.run(requests.record("run1"))
    assert (requests.state.recording, requests.recording_problem) == (None, None)


def test_a_frame_has_what_is_new(state: ViewState) -> None:
    """Rows once, the target, whether it can be moved, and the flows of the newest row."""
    state.target = 0.05
    row = (1.0, 0.01, 0.0, 4e5, 3e5, 6e5, 5.6, 0.05, 5.6, None, None)
    state.history.add(row)
    news, mark = frames.frame(state, Mark())
    assert (news["anew"], news["rows"], news["target"], news["locked"]) == (
        True,
        [row],
        0.05,
        False,
    )
    assert len(news["drawn"]["flows"]) == 4
    assert news["drawn"]["flows"][0] > 0.0
    assert news["drawn"]["motion"] == "■ stuck"
    assert frames.frame(state, mark)[0]["rows"] == []
    state.take_parameters("controller", {"reference.type": "sine"})
    assert frames.frame(state, mark)[0]["locked"]
    assert frames.setup(state)["stroke"] == 0.2


def test_colours_begin_at_the_atmosphere_of_the_rig(state: ViewState) -> None:
    """In the mountains an exhausted chamber has the colour that it has at sea level."""
    assert frames.setup(state)["atmosphere"] == 101325.0
    state.take_parameters("plant", {"atmosphere.pressure": 7e4})
    assert frames.setup(state)["atmosphere"] == 7e4


# Of a rig that says neither its reference nor where spool and piston are.
NOTHING = (None, None, None, None)


def test_a_spool_that_is_stuck_is_drawn_where_it_is(state: ViewState) -> None:
    """Its flows are those of its place, not of the command; the words say so."""
    state.history.add((1.0, 0.01, 0.0, 4e5, 3e5, 6e5, 10.0, 0.05, 0.0, None, None))
    state.take_parameters("plant", {"fault.valve.spool": "stuck"})
    drawn = frames.frame(state, Mark())[0]["drawn"]
    assert drawn["spool"] == 0.0
    assert drawn["valve"] == "spool stuck: B fills, A empties"
    assert drawn["flows"][2] > 10.0 * drawn["flows"][0]


@pytest.mark.parametrize(
    ("piston", "faults", "lost"),
    [
        (0.012, {}, False),
        (0.016, {}, True),
        (0.016, {"coupling.slip_distance": 0.01}, False),
        (0.010, {"fault.carriage.decoupled": True}, True),
    ],
)
def test_a_carriage_is_lost_past_the_reach_of_its_magnets(
    state: ViewState, piston: float, faults: dict[str, object], lost: bool
) -> None:
    """Or where they let go; the page says what each of the two does."""
    state.take_parameters("plant", faults)
    state.history.add((1.0, 0.01, 0.0, 4e5, 3e5, 6e5, 5.6, 0.05, 5.6, piston, 0.08))
    drawn = frames.frame(state, Mark())[0]["drawn"]
    assert drawn["lost"] is lost
    words = "carriage ■ stuck; piston ▶ slipping, 80.0 mm/s"
    assert drawn["motion"] == ("lost " if lost else "") + words


def test_flows_of_a_rig_that_is_not_known_are_not_drawn() -> None:
    """Readings alone do not tell the valve."""
    state = ViewState()
    state.history.add((1.0, 0.01, 0.0, 4e5, 3e5, 6e5, 5.6, *NOTHING))
    assert state.flows() is None
    state.take_parameters("plant", dict(RigParameters()), whole=True)
    assert state.flows() is not None
    state.history.add((2.0, 0.01, 0.0, None, 3e5, 6e5, 5.6, *NOTHING))
    assert state.flows() is None
