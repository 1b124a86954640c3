# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The panels beside the drawing: reference, and the parameters of :mod:`panels`."""

from collections.abc import Sequence
from itertools import chain

from nicegui import ui

from rodless_control.parameters import LAW
from rodless_lab.view.panels import PANELS, REFERENCES, Choice, Panel
from rodless_lab.view.requests import Requests
from rodless_lab.view.widgets import (
    ChoiceField,
    ParameterField,
    attempt,
    button,
    complain,
    tag,
    tell,
)

_KINDS = {
    "setpoint": "Set-point: jump",
    "ramp": "Ramp to set-point",
    "move": "Move to set-point",
    "step": "Step",
    "sine": "Sine",
}


class Steering:
    """What changes the rig."""

    def __init__(self, requests: Requests) -> None:
        """Build it in the element that is open."""
        self._requests = requests
        self._state = requests.state
        with ui.element("div") as self._all:
            with ui.expansion("Reference", value=True):
                self._reference()
            self._panels = [self._panel(panel) for panel in PANELS]
        self.refresh()

    def _reference(self) -> None:
        with ui.element("div").classes("view-row"):
            self._target = (
                ui.number("Set-point, mm", step=1.0)
                .props(f"dense outlined {tag('set-point')}")
                .on("keydown.enter", self._go)
            )
            button("Go", self._go, "go")
        self._kind = ui.select(_KINDS, value="setpoint", on_change=self._chosen).props(
            f'dense outlined aria-label="Kind of reference" {tag("reference")}'
        )
        self._kind.classes("w-full")
        self._shapes = {}
        for kind, fields in REFERENCES.items():
            with ui.element("div") as box:
                self._shapes[kind] = box, [ParameterField(one, self._state, None) for one in fields]
        self._start = button("Start", self._begin, "start")
        self._show_shape()

    def _panel(self, panel: Panel) -> tuple[ui.element, list[ParameterField | ChoiceField]]:
        with ui.expansion(panel.title, value=panel.is_open) as box:
            fields = [
                ChoiceField(one, self._state, self._set)
                if isinstance(one, Choice)
                else ParameterField(one, self._state, self._set)
                for one in panel.fields
            ]
            if any(one.name == "supply.pressure" for one in panel.fields):
                with ui.element("div").classes("view-row"):
                    self._cut = button("Cut supply", self._toggle_supply, "supply")
        return box, fields

    async def _set(self, name: str, value: object) -> None:
        done = await attempt(self._requests.set({name: value}))
        if done and name == LAW:
            then = (
                "it holds the carriage where it is until a set-point comes"
                if self._state.takes_set_points
                else "it goes to the step or begins the sine of its reference"
            )
            tell(f"{value} controls: {then}")

    async def _toggle_supply(self) -> None:
        await attempt(self._requests.cut_supply(not self._requests.supply_is_cut))

    async def _go(self) -> None:
        await attempt(self._send_target())

    async def _send_target(self) -> None:
        if self._target.value is None:
            complain("set-point: give a number")
            return
        # Divided, as `rodless move` does: 350 * 1e-3 is more than 0.35.
        self._requests.set_point(self._target.value / 1e3)

    async def _chosen(self) -> None:
        self._show_shape()
        # Those without a shape of their own are in force at once.
        if not REFERENCES[self._kind.value] and self._kind.value != self._known:
            await self._begin()

    async def _begin(self) -> None:
        kind = self._kind.value
        # Of a controller that is not there no field shows anything; the request says so.
        values: dict[str, object] = {}
        for field, shown in zip(REFERENCES[kind], self._shapes[kind][1], strict=True):
            if shown.value is not None:
                values[field.name] = shown.value
            elif self._state.parameter(field.name) is not None:
                complain(f"{field.label}: give a number")
                return
        await attempt(self._requests.set_reference(kind, values))

    @property
    def _known(self) -> object:
        return self._state.parameter("reference.type")

    def _show_shape(self) -> None:
        for kind, (box, _fields) in self._shapes.items():
            box.set_visibility(kind == self._kind.value)
        self._start.set_visibility(bool(REFERENCES[self._kind.value]))

    _seen: object = None

    def refresh(self) -> None:
        """Follow what the nodes have now."""
        self._all.set_visibility(self._state.live and self._state.playback is None)
        known = self._known
        # One of somebody else's controller may be a list, which no dictionary can be asked for.
        if known != self._seen and isinstance(known, str) and known in REFERENCES:
            self._seen = known
            self._kind.set_value(known)
            self._show_shape()
        shown: list[Sequence[ParameterField | ChoiceField]] = []
        shown += [fields for _box, fields in self._shapes.values()]
        shown += [fields for _box, fields in self._panels]
        for one in chain(*shown):
            one.refresh()
        for (box, _fields), panel in zip(self._panels, PANELS, strict=True):
            known_here = any(self._state.parameter(one.name) is not None for one in panel.fields)
            box.set_visibility(known_here)
        self._cut.set_text("Restore supply" if self._requests.supply_is_cut else "Cut supply")
