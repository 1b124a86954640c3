# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What the parts of a page ask for and show, without a browser."""

import asyncio
import json
from collections.abc import Awaitable, Callable, Mapping
from pathlib import Path
from unittest.mock import AsyncMock

import pytest

from rodless_control import ControllerParameters
from rodless_lab.view.requests import Requests
from rodless_lab.view.state import PLANT, NodeState, ViewState

nicegui = pytest.importorskip("nicegui")


class Asked(Requests):
    """Keeps what is asked for."""

    def __init__(self, state: ViewState) -> None:
        super().__init__(state, Path(), None, None)
        self.references: list[tuple[object, dict[str, object]]] = []

    async def set_reference(self, kind: object, values: Mapping[str, object]) -> None:
        """Take note."""
        self.references.append((kind, dict(values)))


@pytest.fixture
def requests() -> Asked:
    """Of a rig with a stroke of 700 mm."""
    state = ViewState()
    given = {**ControllerParameters(), "reference.maximum": 0.7}
    state.take_parameters("controller", given, whole=True)
    return Asked(state)


def on_a_page(work: Callable[[], Awaitable[None]]) -> None:
    """Do ``work`` where elements can be made: on a page that no browser shows."""
    from nicegui.client import Client  # noqa: PLC0415
    from nicegui.page import page  # noqa: PLC0415

    async def do() -> None:
        with Client(page(""), request=None):
            await work()

    asyncio.run(do())


def test_an_emptied_field_of_a_reference_is_not_sent(
    requests: Asked, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It was sent as 0, and the carriage went there; a 0 that is written is sent."""
    from rodless_lab.view import steering  # noqa: PLC0415

    said: list[str] = []
    monkeypatch.setattr(steering, "complain", said.append)

    async def work() -> None:
        panel = steering.Steering(requests)
        panel._kind.value = "step"
        _start, target = panel._shapes["step"][1]
        for given in (None, 0.0):
            target._number.value = given
            await target._typed()
            await panel._begin()

    on_a_page(work)
    assert said == ["To: give a number"]
    assert requests.references == [("step", {"reference.start": 0.0, "reference.target": 0.0})]


def test_an_emptied_field_of_a_parameter_shows_what_the_node_has(requests: Asked) -> None:
    """Once it is left: nothing is sent, and it does not stay empty."""
    from rodless_lab.view.panels import PANELS, Field  # noqa: PLC0415
    from rodless_lab.view.widgets import ParameterField  # noqa: PLC0415

    gain = PANELS[0].fields[1]
    assert isinstance(gain, Field)
    sent: list[object] = []

    async def submit(name: str, value: object) -> None:
        sent.append((name, value))

    async def work() -> None:
        field = ParameterField(gain, requests.state, submit)
        before = field.value
        field._use(True)
        field._number.value = None
        field.refresh()
        assert field.value is None  # while it is in use it may be empty
        await field._typed()
        assert field.value == before == requests.state.parameter(gain.name)

    on_a_page(work)
    assert sent == []


@pytest.mark.parametrize("millimetres", [350.0, 700.0, 58.0])
def test_the_full_stroke_of_a_cylinder_is_within_it(requests: Asked, millimetres: float) -> None:
    """As for `rodless move`: 350 mm are 0.35 m, to the last bit."""
    from rodless_lab.view.steering import Steering  # noqa: PLC0415

    sent: list[float] = []

    class Points:
        def send_set_point(self, target: float) -> None:
            sent.append(target)

    requests._set_points = Points()
    limit = float(f"{millimetres}e-3")
    requests.state.take_parameters("controller", {"reference.maximum": limit})

    async def work() -> None:
        panel = Steering(requests)
        panel._target.value = millimetres
        await panel._send_target()

    on_a_page(work)
    assert sent == [limit]


@pytest.mark.parametrize("words", ["läuft 😀", '" \' \\ :class=x="y"', "plain"])
def test_a_page_can_be_sent_whatever_a_node_says(requests: Asked, words: str) -> None:
    """What a browser reads is what the node has said; one that could not be sent froze the page."""
    from rodless_lab.view.header import Header  # noqa: PLC0415

    requests.state.nodes[PLANT] = NodeState("OK", words)

    async def work() -> None:
        header = Header(requests)
        header.refresh()
        chip = header._chips[PLANT]
        sent = json.loads(nicegui.json.dumps(chip._to_dict()))
        assert sent["props"]["title"] == sent["text"] == f"plant: {words}"

    on_a_page(work)


def test_a_bag_that_cannot_be_opened_leaves_its_button_as_it_was(
    requests: Asked, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever is wrong with it: a button that loads for ever cannot be clicked again."""
    from rodless_lab.view.bag_panel import BagPanel  # noqa: PLC0415

    monkeypatch.setattr(requests, "open_bags", AsyncMock(side_effect=MemoryError))

    async def work() -> None:
        panel = BagPanel(requests)
        with pytest.raises(MemoryError):
            await panel._open()
        assert "loading" not in panel._opener.props

    on_a_page(work)
