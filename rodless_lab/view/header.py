# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""How the rig is, and what stops and starts it."""

from functools import partial

from nicegui import ui

from rodless_lab.view.requests import Requests
from rodless_lab.view.state import CONTROLLER, PLANT
from rodless_lab.view.widgets import attempt, button, complain, tag, tell

# Of simulated time at a click on Step, in periods.
STEPS = {"Step": 1, "Step ×10": 10}

# Refreshes from one time to the next, while it runs.
TIME_EVERY = 4

_CLASSES = {"OK": "ok", "WARN": "warn"}


class Header:
    """State, plant time and real-time factor."""

    def __init__(self, requests: Requests) -> None:
        """Build it in the element that is open."""
        self._state = state = requests.state
        with ui.element("header").classes("view-head"):
            ui.label("rodless view").classes("view-title")
            if not state.live:
                ui.label("bags")
                return
            ui.label(f"rig {state.namespace}")
            self._chips = {
                node: ui.label().classes("view-chip").props(tag(f"state-{node}"))
                for node in (PLANT, CONTROLLER)
            }
            self._refreshes = 0
            self._time = ui.label().classes("view-number").props(tag("time"))
            self._factor = ui.label().classes("view-number").props(tag("factor"))

    def refresh(self) -> None:
        """Show what the state says now."""
        state = self._state
        if not state.live:
            return
        for node, chip in self._chips.items():
            said = state.nodes[node]
            text = f"{node}: {said.message}"
            if chip.text != text:
                chip.props["title"] = text
                chip.set_text(text)
            chip.classes(add=_CLASSES.get(said.level, "error"), remove="ok warn error")
        # A browser lays out the whole page for each text that changes: time that runs is told once
        # a second.
        self._refreshes += 1
        if state.paused or self._refreshes % TIME_EVERY == 0:
            self._time.set_text("– s" if state.time is None else f"{state.time:.2f} s")
        factor = state.speed_factor
        self._factor.set_text("" if factor is None else f"× {factor:.2f} real time")


class Run:
    """What stops and starts the rig, and what records it."""

    def __init__(self, requests: Requests) -> None:
        """Build it in the element that is open."""
        self._requests = requests
        self._state = requests.state
        self._told: str | None = None
        with ui.element("div").classes("view-row") as self._all:
            self._pause = button("Pause", self.toggle_pause, "pause")
            self._steps = [
                button(text, partial(self._step, count), f"step-{count}")
                for text, count in STEPS.items()
            ]
            button("Reset", self._reset, "reset")
            self._enable = button("Disable", self._toggle_enable, "enable")
            self._record = button("Record", self._toggle_recording, "record")

    async def _reset(self) -> None:
        await attempt(self._requests.reset())

    async def _step(self, count: int) -> None:
        await attempt(self._requests.step(count))

    async def toggle_pause(self) -> None:
        """Pause, or run on."""
        await attempt(self._requests.pause(not self._state.paused))

    async def _toggle_enable(self) -> None:
        await attempt(self._requests.enable(not self._state.enabled))

    async def _toggle_recording(self) -> None:
        if self._state.recording is None:
            await attempt(self._requests.record())
            return
        stop = self._requests.stop_recording()

        async def done() -> None:
            tell(await stop)

        await attempt(done())

    def refresh(self) -> None:
        """Show what can be done now."""
        state = self._state
        self._all.set_visibility(state.live and state.playback is None)
        self._pause.set_text("Resume" if state.paused else "Pause")
        for one in self._steps:
            one.set_enabled(state.paused)
        self._enable.set_text("Disable" if state.enabled else "Enable")
        self._record.set_text(f"Stop {state.recording}" if state.recording else "Record")
        problem = self._requests.recording_problem
        if problem is not None and problem != self._told:
            complain(problem)
        self._told = problem
