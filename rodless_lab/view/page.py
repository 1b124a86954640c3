# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The page: drawing and plots, steering and bags. It keeps nothing but what it shows."""

from pathlib import Path

from nicegui import ui
from nicegui.events import KeyEventArguments

from rodless_lab.view import frames
from rodless_lab.view.bag_panel import BagPanel
from rodless_lab.view.errors import ViewError
from rodless_lab.view.header import Header, Run
from rodless_lab.view.requests import Requests
from rodless_lab.view.rig_view import RigView
from rodless_lab.view.steering import Steering
from rodless_lab.view.widgets import attempt, complain, tag

# How often texts and fields follow the state, in s.
REFRESH = 0.25

STYLE = Path(__file__).with_name("view.css")


def build(requests: Requests) -> None:
    """Build a page for one browser."""
    state = requests.state
    ui.add_css(STYLE.read_text(encoding="utf-8"))

    def aim(target: object) -> None:
        try:
            requests.set_point(target)
        except ViewError as error:
            complain(str(error))

    with ui.element("div").classes("view"):
        header = Header(requests)
        with ui.element("main").classes("view-main"):
            problem = ui.label().classes("view-problem").props(tag("problem"))
            drawing = RigView(state, aim)
        with ui.element("aside").classes("view-side"):
            run = Run(requests)
            steering = Steering(requests)
            bags = BagPanel(requests)

    def refresh() -> None:
        notice = state.notice
        problem.set_visibility(notice is not None)
        problem.set_text(notice or "")
        for part in (header, run, steering, bags):
            part.refresh()

    async def press(event: KeyEventArguments) -> None:
        if not event.action.keydown or event.action.repeat:
            return
        if event.key == " ":
            await (bags.toggle() if state.playback else run.toggle_pause())
        elif event.key == "." and state.live and not state.playback:
            await attempt(requests.step())

    ui.keyboard(on_key=press, ignore=["input", "select", "button", "textarea"])
    ui.timer(1.0 / frames.RATE, drawing.push)
    ui.timer(REFRESH, refresh)
