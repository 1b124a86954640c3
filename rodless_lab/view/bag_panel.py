# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The panel that opens bags, plays them and says how far two are apart."""

from collections.abc import Callable
from html import escape

from nicegui import ui
from nicegui.events import GenericEventArguments

from rodless_lab.view.playback import SPEEDS, Playback
from rodless_lab.view.requests import Requests
from rodless_lab.view.widgets import attempt, button, tag

# While the slider is drawn, in s.
SEEK_PERIOD = 0.05

# Refreshes from one look into the folder to the next.
LIST_EVERY = 4


class BagPanel:
    """One bag, or two on one time; the cursor is everybody's."""

    def __init__(self, requests: Requests) -> None:
        """Build it in the element that is open."""
        self._requests = requests
        self._state = requests.state
        self._shown: Playback | None = None
        self._scrubbing = False
        self._refreshed = 0
        with ui.expansion("Bags", value=not self._state.live):
            self._shelf()
            with ui.element("div") as self._deck:
                self._controls()
        self.refresh()

    def _shelf(self) -> None:
        self._names = (
            ui.select(self._requests.bags, multiple=True, label="One bag, or two to compare")
            .props(f"dense outlined use-chips max-values=2 {tag('bags')}")
            .classes("w-full")
        )
        with ui.element("div").classes("view-row"):
            self._opener = button("Open", self._open, "open")
            self._live = button("Back to the rig", self._close, "live")

    def _controls(self) -> None:
        with ui.element("div").classes("view-row"):
            self._play = button("Play", self.toggle, "play")
            self._speed = ui.select({s: f"× {s:g}" for s in SPEEDS}, value=1.0).props(
                f'dense outlined aria-label="Speed" {tag("speed")}'
            )
            self._speed.on_value_change(self._set_speed)
            self._where = ui.label().classes("view-number").props(tag("cursor"))
        self._cursor = ui.slider(min=0.0, max=1.0, step=0.01).props(
            f'aria-label="Time in the bag, s" {tag("scrub")}'
        )
        self._cursor.on("pan", lambda event: self._scrub(event.args != "end"))
        self._cursor.on("update:model-value", self._seek, throttle=SEEK_PERIOD)
        self._apart = ui.html("", sanitize=False).classes("view-label").props(tag("apart"))
        self._notes = ui.label().classes("view-label view-lines").props(tag("notes"))

    def _list(self) -> None:
        """Offer the bags that are in the folder now, once a second."""
        self._refreshed += 1
        if self._refreshed % LIST_EVERY:
            return
        bags = self._requests.bags
        if bags != self._names.options:
            chosen = [name for name in self._names.value or [] if name in bags]
            self._names.set_options(bags, value=chosen)

    async def _open(self) -> None:
        self._opener.props("loading")  # long bags take a while
        try:
            await attempt(self._requests.open_bags(list(self._names.value or [])))
        finally:
            self._opener.props(remove="loading")

    async def _close(self) -> None:
        await self._now(self._requests.close_bags)

    async def toggle(self) -> None:
        """Play, or stop."""
        playing = self._state.playback is not None and self._state.playback.playing
        await self._now(lambda: self._requests.play(not playing))

    async def _set_speed(self) -> None:
        if self._shown is not None and self._speed.value != self._shown.speed:
            await self._now(lambda: self._requests.set_speed(self._speed.value))

    def _scrub(self, scrubbing: bool) -> None:
        self._scrubbing = scrubbing

    async def _seek(self, event: GenericEventArguments) -> None:
        await self._now(lambda: self._requests.seek(event.args))

    @staticmethod
    async def _now(work: Callable[[], None]) -> None:
        async def do() -> None:
            work()

        await attempt(do())

    def refresh(self) -> None:
        """Follow the state."""
        self._list()
        playback = self._state.playback
        self._deck.set_visibility(playback is not None)
        self._live.set_visibility(playback is not None and self._state.live)
        if playback is None:
            self._shown = None
            return
        if playback is not self._shown:
            self._shown = playback
            self._cursor.props(f":min={playback.begin:.6f} :max={playback.end:.6f}")
            self._apart.set_content(_table(playback))
            self._notes.set_text("\n".join(playback.notes))
        self._play.set_text("Stop" if playback.playing else "Play")
        if self._speed.value != playback.speed:
            self._speed.set_value(playback.speed)
        now = playback.cursor
        self._where.set_text(f"{now:.2f} of {playback.end:.2f} s")
        if not self._scrubbing and self._cursor.value != now:
            self._cursor.set_value(now)


def _table(playback: Playback) -> str:
    """Return names, and how far two runs are apart, as HTML."""
    names = [escape(tape.name) for tape in playback.tapes]
    if len(names) == 1:
        return f"<b>{names[0]}</b>"
    rows = "".join(
        f"<tr><td>{one.label}&nbsp;</td><td>{one.largest:.3g}&nbsp;</td>"
        f"<td>{one.rms:.3g} {one.unit}</td></tr>"
        for one in playback.apart
    )
    return (
        f"<b>{names[0]}</b> (thin) and <b>{names[1]}</b> (broad)"
        f"<table><tr><td>apart by</td><td>at most&nbsp;</td><td>rms</td></tr>{rows}</table>"
    )
