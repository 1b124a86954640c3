# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What a move waits for before it sends its set-point, and before it ends; without ROS."""

import time
from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticStatus

from rodless_lab.session.diagnostic import Diagnostic
from rodless_lab.session.errors import InterruptedRunError
from rodless_lab.session.move import SetpointMove
from rodless_lab.session.running_rig import RunningRig


class Rig(RunningRig):
    """A rig whose nodes are unknown, and whose topics have a publisher each."""

    def __init__(self, arrivals: Iterator[bool]) -> None:
        publisher = SimpleNamespace(
            topic_name="/setpoint",
            publish=lambda _: None,
            wait_for_all_acked=lambda _: next(arrivals),
        )
        self.observer: Any = SimpleNamespace(
            node=SimpleNamespace(count_publishers=lambda _: 1),
            publisher=lambda *_, **__: publisher,
            subscribe=lambda *_, **__: None,
        )

    def wait_for(self, condition: Callable[[], object], timeout: float) -> bool:  # noqa: ARG002
        """Ask a hundred times."""
        return any(condition() for _ in range(100))

    def wait_for_node(self, node: str, timeout: float) -> None:
        """It is there."""

    def is_known(self, node: str) -> bool:  # noqa: ARG002
        """Nothing is asked of the nodes."""
        return False

    def diagnostic(self, node: str) -> None:
        """They report nothing."""

    def name(self, node: str) -> str:
        """It is in the root namespace."""
        return f"/{node}"

    def check_alone(self) -> None:
        """There is no other."""


class Track:
    """A carriage that is there at once, by a controller whose first commands take their time."""

    has_samples = has_references = has_settled = True
    was_reset = is_elsewhere = is_taken = False

    def __init__(self, commands: Iterator[bool]) -> None:
        self._commands = commands

    @property
    def has_commands(self) -> bool:
        """As given."""
        return next(self._commands)

    def begin(self, *_: object) -> None:
        """Nothing to do."""

    take_sample = take_reference = take_voltage = begin

    def result(self) -> str:
        """What the test looks for."""
        return "measured"


@pytest.fixture(autouse=True)
def _others(monkeypatch: pytest.MonkeyPatch) -> None:
    """All who listen to set-points and send them are matched."""
    monkeypatch.setattr("rodless_lab.session.move.setpoint_is_heard", lambda *_: True)
    monkeypatch.setattr("rodless_lab.session.move.hears_all_setpoints", lambda *_: True)


@pytest.mark.parametrize("late", [0, 1, 50])
def test_a_move_waits_for_commands_and_for_every_listener(
    monkeypatch: pytest.MonkeyPatch, late: int
) -> None:
    """Commands that it measures come before it sends, the last receipt before it ends.

    So do those who might send another set-point: of one unmatched, it could not tell the number.
    A recorder that has come since the controller was found is waited for too.
    """
    answers = [False] * late + [True]
    commands, arrivals, matches = iter(answers), iter(answers), iter(answers)
    heard = iter([True, *answers])
    monkeypatch.setattr("rodless_lab.session.move.setpoint_is_heard", lambda *_: next(heard))
    monkeypatch.setattr("rodless_lab.session.move.hears_all_setpoints", lambda *_: next(matches))
    move = SetpointMove(Rig(arrivals), 0.058)
    move.track = Track(commands)
    move.prepare()
    assert list(commands) == list(matches) == list(heard) == []
    assert move.make(1.0, lambda _: None, lambda _: None) == "measured"
    assert list(arrivals) == []


def test_what_comes_after_a_move_does_not_change_how_it_ended() -> None:
    """It has settled; another set-point is sent while a killed listener is waited for."""

    def never() -> Iterator[bool]:
        while True:
            move._newest = (1, 0.1)
            move.track.has_settled = False  # type: ignore[misc]
            yield False

    move = SetpointMove(Rig(never()), 0.058)
    move.track = Track(iter([True]))
    move.prepare()
    move._send = lambda: setattr(move, "_is_out", True)  # type: ignore[method-assign]
    move._newest = (0, 0.058)
    assert move.make(1.0, lambda _: None, lambda _: None) == "measured"
    assert move._is_overtaken


def test_who_has_been_killed_does_not_hold_a_move_back_for_ever(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A listener never says that it has the set-point; a sender is never matched."""

    def never() -> Iterator[bool]:
        while True:
            yield False

    monkeypatch.setattr("rodless_lab.session.move.hears_all_setpoints", lambda *_: False)
    move = SetpointMove(Rig(never()), 0.058)
    move.track = Track(iter([True]))
    move.prepare()
    assert move.make(1.0, lambda _: None, lambda _: None) == "measured"


def test_who_does_not_wait_for_the_last_receipt_keeps_the_measurement() -> None:
    """Ctrl-C in the seconds for a listener that was killed: the move is over and measured."""

    def interrupted() -> Iterator[bool]:
        raise InterruptedRunError
        yield

    move = SetpointMove(Rig(interrupted()), 0.058)
    move.track = Track(iter([True]))
    move.prepare()
    assert move.make(1.0, lambda _: None, lambda _: None) == "measured"


MUST = "refused, must be from reference.minimum (0 m) to reference.maximum (0.05 m)"


@pytest.mark.parametrize(
    ("line", "refused"),
    [
        (f"set-point: 0.058 m {MUST}", True),
        ("set-point: 0.058 m ignored, reference.type is sine; set-points need setpoint", True),
        ("set-point: ignored, the controller is disabled; ~/enable it first", True),
        (f"set-point: 0.3 m {MUST}", False),
        ("set-point: nan m refused, must be a finite number", False),
        ("command: refused, it names the joints gripper, not carriage", False),
    ],
)
def test_what_another_has_sent_wrong_is_not_this_moves(line: str, *, refused: bool) -> None:
    """The controller's log has a line for everybody."""
    move = SetpointMove(Rig(iter([True])), 0.058)
    move._take_log(SimpleNamespace(name="controller", msg=line))
    assert move._is_refused is refused


@pytest.mark.parametrize(
    ("before", "count", "late", "refused"),
    [(3, 4, 1.0, True), (3, 3, 1.0, False), (None, 4, 1.0, False), (3, 4, 0.0, False)],
)
def test_what_was_refused_before_is_not_counted(
    before: int | None, count: int, late: float, *, refused: bool
) -> None:
    """Nor while the reference may still follow, nor where nothing was known."""

    def report(number: int | None, arrived: float) -> Diagnostic | None:
        if number is None:
            return None
        values = {"set-points refused": str(number)}
        return Diagnostic(DiagnosticStatus.OK, "controlling", values, arrived)

    class Told(Rig):
        said = report(before, time.monotonic())

        def diagnostic(self, node: str) -> Diagnostic | None:  # type: ignore[override]
            return self.said if node == "controller" else None

    rig = Told(iter([True]))
    move = SetpointMove(rig, 0.058)
    move.track = Track(iter([True]))
    move._listen()
    move._send()
    rig.said = report(count, time.monotonic() + late)
    assert move._is_refused is refused
