"""Plant time driven by commands: one period for each, as fast as they come."""

import time
from collections.abc import Callable

from rodless_sim.node.engine import Engine


class Lockstep:
    """Answers each command with the next sample.

    It runs while exactly one publisher of commands is there: with two, nobody knows whose answer
    is whose. When it runs again, the last sample is offered anew.

    Exactly one sample is unanswered at any time. A reset therefore waits for its answer and
    drops it: taken for the answer to sample 0, it would set the loop one sample apart for good.
    Where nobody answers, the reset happens after ``timeout``.
    """

    def __init__(
        self,
        engine: Engine,
        timeout: float,
        ready: Callable[[], bool],
        commanders: Callable[[], int],
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        """Offer sample 0 as soon as ``ready``, and to one publisher of commands only.

        ``commanders`` counts the publishers of commands; ``timeout`` is in s of ``now``.
        """
        self._engine = engine
        self._timeout = timeout
        self._ready = ready
        self._commanders = commanders
        self._now = now
        self._running = False
        self._paused = False
        self._pending: float | None = None
        self._reset_wanted = False
        self._offered_at = 0.0
        self.overruns = 0

    @property
    def problem(self) -> str | None:
        """What keeps the plant from following commands now."""
        if self._engine.failure is not None:
            return self._engine.failure
        if not self._running and self._commanders() > 1:
            return "more than one publisher on valve/voltage: holding until one is left"
        if not self._running:
            return "waiting for subscribers and for one publisher on valve/voltage"
        if self._overdue and not self._engine.ended:
            return f"no command for {self._timeout:g} s of wall time: holding"
        return None

    @property
    def _overdue(self) -> bool:
        return self._pending is None and self._now() - self._offered_at > self._timeout

    @property
    def paused(self) -> bool:
        """Whether plant time stands still by request."""
        return self._paused

    @property
    def running(self) -> bool:
        """Whether plant time advances with each command now."""
        held = self._paused or self._engine.ended or self._engine.failure is not None
        return self._running and not held

    @property
    def at_start(self) -> bool:
        """Whether plant time is zero."""
        return self._engine.rig.nanoseconds == 0

    @property
    def steps_by_itself(self) -> bool:
        """Whether several steps can be taken at once, without an answer to each."""
        return False

    def receive(self, voltage: float) -> None:
        """Take the answer (V) to the last sample."""
        if not self._running:
            return
        if self._reset_wanted:
            self._restart()
            return
        self._pending = voltage
        if not self._paused:
            self._answer()

    def pause(self, paused: bool) -> None:
        """Keep the next answer back, or let it take effect."""
        self._paused = paused
        if not paused and self._pending is not None:
            self._answer()

    def step(self) -> str | None:
        """Let one answer take effect; return what is in the way, if anything."""
        if self._engine.failure is not None:
            return self._engine.failure
        if not self._paused:
            return "pause the plant first"
        if self._pending is None:
            return "no command has come for the last sample yet"
        self._answer()
        return None

    def reset(self) -> str:
        """Return to the start as soon as no answer is under way; say when that is."""
        answered = self._pending is not None or self._engine.failure is not None
        if self._running and not answered and not self._overdue:
            self._reset_wanted = True
            return "with the answer to the last sample"
        self._restart()
        return "done"

    def poll(self) -> None:
        """Do what no command triggers: start, hold without a sole commander, give up waiting."""
        alone = self._commanders() == 1
        if self._running and not alone:
            self._running = False
            self._pending = None
        elif not self._running and alone and self._ready():
            self._running = True
            self._offer()
        elif self._running and self._overdue:
            self._wait_no_longer()

    def close(self) -> None:
        """Nothing runs by itself."""

    def _wait_no_longer(self) -> None:
        if self._reset_wanted:
            self._restart()
        elif self._engine.rig.nanoseconds == 0 and not self._engine.command.received:
            # A controller that published before it was matched lost its first answer.
            self._offer()

    def _restart(self) -> None:
        self._reset_wanted = False
        self._pending = None
        self._offered_at = self._now()
        self._engine.reset()

    def _offer(self) -> None:
        self._offered_at = self._now()
        self._engine.offer()

    def _answer(self) -> None:
        voltage, self._pending = self._pending, None
        if voltage is None or self._engine.ended:
            return
        self._engine.receive(voltage)
        self._engine.step()
        self._offered_at = self._now()
