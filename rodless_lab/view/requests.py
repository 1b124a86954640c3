# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What pages may ask for: checked here, then done as everybody else's requests are."""

import asyncio
import math
import stat
from collections.abc import Mapping
from concurrent.futures import Future
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from rodless_base.atomic_write import named_or_as_it_is
from rodless_base.one_line import shown
from rodless_lab.bags.default_bag import default_bag
from rodless_lab.bags.metadata import METADATA_FILE
from rodless_lab.session.errors import HarnessError
from rodless_lab.session.reset import RESET
from rodless_lab.view import inputs
from rodless_lab.view.errors import ViewError
from rodless_lab.view.panels import REFERENCES, TIMED
from rodless_lab.view.playback import Playback, open_tape
from rodless_lab.view.recording import Recording
from rodless_lab.view.state import ViewState

# From a request for a step or sine to its start, in plant s.
LEAD = 0.5

# The supply when it is cut: that of the atmosphere.
ATMOSPHERE = "atmosphere.pressure"
SUPPLY = "supply.pressure"


class SetPoints(Protocol):
    """Who sends set-points."""

    def send_set_point(self, target: float) -> None:
        """Publish a set-point (m)."""


class Nodes(Protocol):
    """Who asks the nodes."""

    def set_parameters(self, given: Mapping[str, str]) -> "Future[None]":
        """Set parameters, all or none."""

    def call(self, services: Mapping[str, bool | None], times: int = 1) -> "Future[None]":
        """Call services."""


@dataclass
class _Cut:
    """What the supply (Pa) was before it was cut here, and the last restart of the same rig."""

    supply: float
    last_restart: int


class Requests:
    """Everything raises :class:`ViewError` where it cannot be; then nothing has changed."""

    def __init__(
        self, state: ViewState, folder: Path, set_points: SetPoints | None, nodes: Nodes | None
    ) -> None:
        """Serve the pages of ``state``; bags are in ``folder``. Without nodes bags alone."""
        self.state = state
        self._folder = folder
        self._set_points = set_points
        self._nodes = nodes
        self._recording: Recording | None = None
        self._cut: _Cut | None = None

    def close(self) -> None:
        """Close the bag under way."""
        if self._recording is not None:
            self._recording.stop()

    # The rig

    def set_point(self, value: object) -> None:
        """Send a set-point (m)."""
        target = inputs.set_point(value, self._parameters)
        if self._set_points is None:
            raise ViewError(_NO_RIG)
        self._set_points.send_set_point(target)

    @property
    def _parameters(self) -> Mapping[str, object]:
        return {**self.state.parameters["plant"], **self.state.parameters["controller"]}

    async def set(self, values: Mapping[str, object]) -> None:
        """Set parameters by name, all or none."""
        texts = {name: inputs.parameter_text(value) for name, value in values.items()}
        await asyncio.wrap_future(self._asked.set_parameters(texts))

    async def set_reference(self, kind: object, values: Mapping[str, object]) -> None:
        """Follow set-points, or a ramp, move, step or sine with these parameters."""
        if not isinstance(kind, str) or kind not in REFERENCES:
            raise ViewError(
                f"reference.type: {shown(kind)} refused, must be {', '.join(REFERENCES)}"
            )
        given: dict[str, object] = {"reference.type": kind, **values}
        if kind in TIMED:
            given["reference.at"] = round((self.state.time or 0.0) + LEAD, 3)
        await self.set(given)

    @property
    def supply_is_cut(self) -> bool:
        """Whether the supply has no more pressure than the atmosphere."""
        supply = self.state.parameter(SUPPLY)
        ambient = self.state.parameter(ATMOSPHERE)
        return isinstance(supply, float) and isinstance(ambient, float) and supply <= ambient

    async def cut_supply(self, cut: bool) -> None:
        """Let the supply down to the atmosphere, or give it the pressure it had before."""
        supply, ambient = self.state.parameter(SUPPLY), self.state.parameter(ATMOSPHERE)
        if not isinstance(supply, float) or not isinstance(ambient, float):
            raise ViewError(f"the plant has no {SUPPLY}, or has not told it yet")
        if cut == self.supply_is_cut:
            return
        before, wanted, then = self._cut, ambient, None
        if cut:
            then = _Cut(supply, self.state.history.restarts)
        elif before is None or self.state.history.restarts > before.last_restart:
            raise ViewError(f"the supply of this rig was not cut here; set {SUPPLY}")
        else:
            wanted = before.supply
        # First: pages see the change, and may ask for the next, before its answer is here.
        self._cut = then
        try:
            await self.set({SUPPLY: wanted})
        except ViewError:
            self._cut = before
            raise

    async def pause(self, paused: bool) -> None:
        """Stop plant time, or let it run on."""
        await self._call({"plant/pause": paused})

    async def step(self, steps: object = 1) -> None:
        """Advance a paused plant by some periods."""
        await self._call({"plant/step": None}, inputs.steps(steps))

    async def reset(self) -> None:
        """Return the rig to its start."""
        await self._call(RESET)
        if self._cut is not None:
            self._cut.last_restart += 1

    async def enable(self, enabled: bool) -> None:
        """Let the controller control, or close the valve and keep it closed."""
        await self._call({"controller/enable": enabled})

    async def _call(self, services: Mapping[str, bool | None], times: int = 1) -> None:
        await asyncio.wrap_future(self._asked.call(services, times))

    @property
    def _asked(self) -> Nodes:
        if self._nodes is None:
            raise ViewError(_NO_RIG)
        return self._nodes

    # Bags

    @property
    def bags(self) -> list[str]:
        """Names of what may be bags in the folder, the latest first."""
        try:
            closed = [(_closed_at(one), one.name) for one in self._folder.iterdir()]
        except OSError:
            return []
        return [name for at, name in sorted(closed, reverse=True) if at > -math.inf]

    async def record(self, name: object = None) -> None:
        """Begin a bag of this name, or named after the time."""
        if self._nodes is None:
            raise ViewError(_NO_RIG)
        if self._recording is not None:
            raise ViewError(f"{self._recording.path.name} is being recorded; stop it first")
        path = self._folder / (inputs.bag_name(name) if name else default_bag().name)
        if path.exists():
            raise ViewError(f"{path.name}: exists already; a bag is never written over")
        try:
            self._recording = Recording(path, self.state.namespace)
        except OSError as error:  # such as a full /tmp, where the recorder prints
            raise ViewError(f"{path.name}: {named_or_as_it_is(error)}") from error
        except HarnessError as error:
            raise ViewError(f"{path.name}: {error}") from error
        self.state.recording = path.name

    async def stop_recording(self) -> str:
        """Close the bag; return what is in it."""
        recording, self._recording = self._recording, None
        if recording is None:
            raise ViewError("nothing is being recorded")
        try:
            return await asyncio.to_thread(recording.stop)
        finally:
            self.state.recording = None

    @property
    def recording_problem(self) -> str | None:
        """Why nothing is recorded any more, though it should be."""
        return None if self._recording is None else self._recording.problem

    async def open_bags(self, names: object) -> None:
        """Show one bag of the folder, or two on one time, in place of the rig."""
        if not isinstance(names, list) or not 1 <= len(names) <= 2:
            raise ViewError("choose one bag, or two")
        listed = set(self.bags)
        chosen = (n if isinstance(n, str) and n in listed else inputs.bag_name(n) for n in names)
        paths = [self._folder / name for name in chosen]
        self.state.playback = await asyncio.to_thread(open_playback, paths)

    def close_bags(self) -> None:
        """Show the rig again."""
        if not self.state.live:
            raise ViewError(_NO_RIG)
        self.state.playback = None

    def play(self, playing: bool) -> None:
        """Let the bags play, or stop them."""
        self._playback.play(playing)

    def seek(self, when: object) -> None:
        """Go to a time (s) of the bags."""
        self._playback.seek(inputs.finite(when, "time"))

    def set_speed(self, speed: object) -> None:
        """Play so much faster than plant time."""
        self._playback.set_speed(inputs.finite(speed, "speed"))

    @property
    def _playback(self) -> Playback:
        if self.state.playback is None:
            raise ViewError("no bag is open")
        return self.state.playback


_NO_RIG = "this view shows bags alone; start it without a bag to join a rig"


def open_playback(paths: list[Path]) -> Playback:
    """Read one bag or two; raises :class:`ViewError`."""
    return Playback([open_tape(path) for path in paths])


def _closed_at(bag: Path) -> float:
    """Return when a bag was closed (s); minus infinity for what is none, or may not be entered."""
    try:
        found = (bag / METADATA_FILE).stat()
    except OSError:
        return -math.inf
    return found.st_mtime if stat.S_ISREG(found.st_mode) else -math.inf
