# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The drawing and the plots of a page: an element that is fed frames and tells targets."""

from collections.abc import Callable

from nicegui import ui

from rodless_lab.view import frames
from rodless_lab.view.samples import Mark
from rodless_lab.view.state import ViewState


class RigView(ui.element, component="rig_view.js", esm={"rodless-view": "static"}):
    """Draws in the browser; the server sends what is new alone."""

    def __init__(self, state: ViewState, on_target: Callable[[object], None]) -> None:
        """Show ``state``; call ``on_target`` with where the user wants the carriage (m)."""
        super().__init__()
        self._state = state
        self._mark = Mark()
        self._set_up: tuple[object, ...] | None = None
        self._said: tuple[object, ...] = ()
        self._ready = False
        self.on("ready", self._begin)
        self.on("target", lambda event: on_target(event.args))

    def _begin(self) -> None:
        self._ready = True
        self._set_up = None

    def push(self) -> None:
        """Send what is new, if anything."""
        if not (self._ready and self.client.has_socket_connection):
            return
        state = self._state
        drawn_by = (state.stroke, state.atmosphere, state.closed_voltage)
        key = (state.playback, drawn_by, state.terms)
        if key != self._set_up:
            self._set_up, self._mark, self._said = key, Mark(), ()
            self.run_method("setup", frames.setup(state))
        news, mark = frames.frame(state, self._mark)
        said = (mark, news.get("cursor"), news.get("target"), news.get("locked"))
        if said != self._said:
            self._mark, self._said = mark, said
            self.run_method("frame", news)
