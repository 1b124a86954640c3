# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What advances plant time: what real time and lock-step have in common."""

from abc import ABC, abstractmethod
from typing import Protocol

from rodless_sim.node.engine import Engine

# What a reset says that has taken effect.
RESET_DONE = "done"

# What a step says that can be taken in a moment.
NO_COMMAND_YET = "no command has come for the last sample yet"

RUN_IS_OVER = "time.duration is over; ~/reset begins anew"


class Outgoing(Protocol):
    """Messages that have not gone out, as where a reader holds them back."""

    def flush(self) -> bool:
        """Try to get them through; return whether none is left."""

    def clear(self) -> bool:
        """Forget them; return whether there were any."""

    @property
    def obstacle(self) -> str | None:
        """Who holds them back."""


class TimeKeeper(ABC):
    """Steps an engine, unless it is paused, has ended or has failed."""

    # Whether several steps can be taken at once, without an answer to each.
    steps_by_itself: bool

    def __init__(self, engine: Engine) -> None:
        """Keep the time of ``engine``; nothing advances yet."""
        self._engine = engine
        self._paused = False
        self._started = False

    @property
    def paused(self) -> bool:
        """Whether plant time stands still by request."""
        return self._paused

    @property
    def ending(self) -> str | None:
        """Why plant time stands still until a reset, paused or not; None where it does not."""
        if self._engine.failure is not None:
            return f"stands still: {self._engine.failure}"
        over = f"stands still: {RUN_IS_OVER}"
        return over if self._engine.ended else None

    @property
    def running(self) -> bool:
        """Whether plant time is meant to advance now."""
        held = self._paused or self._engine.ended or self._engine.failure is not None
        return self._started and not held

    @property
    def at_start(self) -> bool:
        """Whether plant time is zero."""
        return self._engine.rig.nanoseconds == 0

    @property
    def overruns(self) -> int:
        """Periods that the machine could not keep."""
        return 0

    @property
    @abstractmethod
    def problem(self) -> str | None:
        """What keeps the plant from following commands now."""

    @abstractmethod
    def receive(self, voltage: float, number: int | None = None) -> None:
        """Take a command (V); its publisher's ``number`` for it, if the middleware has any."""

    @abstractmethod
    def connect(self, in_all: int) -> None:
        """Take note of a publisher of commands; ``in_all`` are those that have gone again, too."""

    @abstractmethod
    def pause(self, paused: bool) -> None:
        """Stop plant time, or let it run on."""

    @abstractmethod
    def step(self) -> str | None:
        """Advance a paused plant by one period; return what is in the way, if anything."""

    @abstractmethod
    def reset(self) -> str:
        """Return to the start; say when that takes effect."""

    @abstractmethod
    def poll(self) -> None:
        """Do what no command triggers; to be called every few hundredths of a second."""

    @abstractmethod
    def close(self) -> None:
        """End what runs by itself."""
