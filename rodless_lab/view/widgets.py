# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Parts of a page that several panels use."""

from collections.abc import Awaitable, Callable
from typing import Any

from nicegui import ui

from rodless_lab.view.errors import ViewError
from rodless_lab.view.panels import Choice, Field
from rodless_lab.view.state import ViewState

# How long a refusal is shown, in ms.
SHOWN = 8000

# A button that is clicked with a mouse lets the keyboard go: Space is to pause, not to click again.
LET_GO = "(event) => event.detail && setTimeout(() => document.activeElement?.blur())"

Submit = Callable[[str, object], Awaitable[None]]


async def attempt(work: Awaitable[object]) -> bool:
    """Do ``work``; show in words why it cannot be done, and return whether it was."""
    try:
        await work
    except ViewError as error:
        complain(str(error))
        return False
    return True


def complain(text: str) -> None:
    """Show what was refused."""
    ui.notify(text, type="negative", position="bottom-left", multi_line=True, timeout=SHOWN)


def tell(text: str) -> None:
    """Show what was done."""
    ui.notify(text, type="positive", position="bottom-left", multi_line=True)


def button(text: str, click: Callable[[], object], name: str) -> ui.button:
    """Return a button with a word on it; ``name`` finds it in tests."""
    made = ui.button(text, on_click=click).props(
        f'no-caps outline dense padding="xs md" {tag(name)}'
    )
    made.on("click", js_handler=LET_GO)
    return made


def tag(name: str) -> str:
    """Return the property that tests find an element by."""
    return f"data-testid={name}"


class ParameterField:
    """A slider and a number for one parameter; both follow the node unless they are in use."""

    def __init__(self, field: Field, state: ViewState, submit: Submit | None) -> None:
        """Show a parameter of ``state``; ``submit(name, value)`` is called with changes, if any.

        Without ``submit`` the field keeps what the user gives until it is read.
        """
        self._field = field
        self._state = state
        self._submit = submit
        self._in_use = False
        self._seen: float | None = None
        with ui.element("div").classes("view-field") as self._box:
            ui.label(f"{field.label}, {field.unit}").classes("view-label")
            self._slider = ui.slider(min=field.low, max=field.high, step=field.step).props(
                f'aria-label="{field.label}, {field.unit}" {tag(field.name + "-slider")}'
            )
            self._number = ui.number(step=field.step).props(
                f'dense outlined aria-label="{field.label}, {field.unit}" {tag(field.name)}'
            )
        self._slider.on("pan", lambda event: self._use(event.args != "end"))
        self._slider.on_value_change(lambda event: self._number.set_value(event.value))
        self._slider.on("change", self._slid)
        self._number.on("focus", lambda: self._use(True))
        self._number.on("blur", self._typed)
        self._number.on("keydown.enter", self._typed)
        self.refresh()

    @property
    def value(self) -> float | None:
        """What is shown, in the parameter's own unit; None where nothing is."""
        shown = self._number.value
        return None if shown is None else self._field.own(shown)

    def _use(self, in_use: bool) -> None:
        self._in_use = in_use

    async def _slid(self) -> None:
        self._number.set_value(self._slider.value)
        await self._send()

    async def _typed(self) -> None:
        self._use(False)
        await self._send()

    async def _send(self) -> None:
        wanted = self._number.value
        if self._submit is None or wanted == self._seen:
            return
        if wanted is not None:
            await self._submit(self._field.name, self._field.own(wanted))
        self._seen = None  # whatever came of it: show what the node has
        self.refresh()

    def refresh(self) -> None:
        """Show what the node has now; nothing where no node has it."""
        value = self._state.parameter(self._field.name)
        self._box.set_visibility(isinstance(value, int | float))
        if not isinstance(value, int | float) or self._in_use:
            return
        shown = self._field.shown(value)
        if shown != self._seen:
            self._seen = shown
            self._number.set_value(shown)
            self._slider.set_value(shown)


class ChoiceField:
    """A list of the values that one parameter can have; it follows the node."""

    def __init__(self, choice: Choice, state: ViewState, submit: Submit) -> None:
        """Show a parameter of ``state``; ``submit(name, value)`` is called with another choice."""
        self._choice = choice
        self._state = state
        self._submit = submit
        self._asking = False
        self._options: dict[Any, str] = dict(choice.options)
        self._select = ui.select(self._options, label=choice.label).props(
            f"dense outlined {tag(choice.name)}"
        )
        self._select.classes("w-full").on_value_change(self._chosen)
        self.refresh()

    async def _chosen(self) -> None:
        wanted = self._select.value
        if wanted is None or wanted == self._state.parameter(self._choice.name):
            return
        self._asking = True  # until there is an answer, what was chosen stands
        try:
            await self._submit(self._choice.name, wanted)
        finally:
            self._asking = False
        self.refresh()  # whatever came of it: show what the node has

    def refresh(self) -> None:
        """Show what the node has now; nothing where no node has it."""
        value = self._state.parameter(self._choice.name)
        where = self._choice.where
        offered = where is None or self._state.parameter(where[0]) == where[1]
        self._select.set_visibility(value is not None and offered)
        if not isinstance(value, str | bool) or self._asking or value == self._select.value:
            return
        if value not in self._options:  # such as a law of the user's own
            self._options[value] = str(value)
            self._select.set_options(self._options)
        self._select.set_value(value)
