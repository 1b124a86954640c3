# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Commands made safe: late, missing, out of range or no number at all."""

import math

import pytest

from rodless_sim.node.command import CommandInput

CLOSED = 5.08
MILLISECOND = 1_000_000


def commands(timeout: float = 0.1) -> CommandInput:
    """An input whose commands count for ``timeout`` seconds."""
    return CommandInput(CLOSED, timeout)


def counters(found: CommandInput) -> tuple[int, int, int, int]:
    """Received, clamped, not finite, timeouts."""
    return found.received, found.clamped, found.not_finite, found.timeouts


def test_before_any_command_the_valve_is_closed() -> None:
    """However long that takes it is no timeout: nothing has been lost."""
    found = commands()
    assert [found.voltage(k * 1000 * MILLISECOND) for k in range(5)] == [CLOSED] * 5
    assert not found.present
    assert counters(found) == (0, 0, 0, 0)


def test_a_command_holds_until_its_time_is_up() -> None:
    """In plant time, to the nanosecond: at the timeout it still counts, just after no more."""
    found = commands(0.1)
    start = 7 * MILLISECOND
    found.receive(6.5, start)
    assert found.voltage(start) == 6.5
    assert found.voltage(start + 100 * MILLISECOND) == 6.5
    assert found.present
    assert found.voltage(start + 100 * MILLISECOND + 1) == CLOSED
    assert not found.present
    assert counters(found) == (1, 0, 0, 1)


def test_each_command_starts_the_time_anew() -> None:
    """The latest one counts, with its own time."""
    found = commands(0.1)
    for k in range(20):
        found.receive(4.0 + 0.1 * k, k * 90 * MILLISECOND)
        assert found.voltage((k * 90 + 89) * MILLISECOND) == 4.0 + 0.1 * k
    assert counters(found) == (20, 0, 0, 0)


def test_one_silence_is_one_timeout() -> None:
    """It is counted once, not at every look; a command ends it, and it may come again."""
    found = commands(0.1)
    for silence in (1, 2, 3):
        found.receive(6.0, silence * 1000 * MILLISECOND)
        assert found.voltage((silence * 1000 + 50) * MILLISECOND) == 6.0
        late = [found.voltage((silence * 1000 + 200 + k) * MILLISECOND) for k in range(9)]
        assert late == [CLOSED] * 9
        assert found.timeouts == silence


@pytest.mark.parametrize("voltage", [math.nan, math.inf, -math.inf])
def test_what_is_no_number_closes_the_valve_at_once(voltage: float) -> None:
    """The command before it is gone too; the next good one opens the valve again."""
    found = commands()
    found.receive(7.0, 0)
    found.receive(voltage, MILLISECOND)
    assert found.voltage(MILLISECOND) == CLOSED
    assert not found.present
    found.receive(3.0, 2 * MILLISECOND)
    assert found.voltage(2 * MILLISECOND) == 3.0
    assert found.present
    assert counters(found) == (3, 0, 1, 0)


def test_a_stream_of_nan_is_no_timeout() -> None:
    """Each is counted for what it is; the silence after them loses nothing."""
    found = commands(0.1)
    for k in range(50):
        found.receive(math.nan, k * MILLISECOND)
    assert found.voltage(5000 * MILLISECOND) == CLOSED
    assert counters(found) == (50, 0, 50, 0)


@pytest.mark.parametrize(
    ("voltage", "taken"),
    [(12.0, 10.0), (-1.0, 0.0), (1e308, 10.0), (-1e308, 0.0), (10.000001, 10.0), (-1e-300, 0.0)],
)
def test_what_is_out_of_range_is_clamped_and_counted(voltage: float, taken: float) -> None:
    """The valve goes to the nearest end, and a diagnostic can say so."""
    found = commands()
    found.receive(voltage, 0)
    assert found.voltage(0) == taken
    assert counters(found) == (1, 1, 0, 0)


@pytest.mark.parametrize("voltage", [0.0, -0.0, 5e-324, 5.08, 9.999999, 10.0])
def test_what_is_in_range_passes_unchanged(voltage: float) -> None:
    """Ends included, and nothing is counted."""
    found = commands()
    found.receive(voltage, 0)
    assert found.voltage(0) == voltage
    assert counters(found) == (1, 0, 0, 0)


def test_a_reset_forgets_the_command_and_keeps_the_count() -> None:
    """The plant starts again with a closed valve, at time zero; faults stay visible."""
    found = commands(0.1)
    found.receive(12.0, 900 * MILLISECOND)
    found.receive(math.nan, 901 * MILLISECOND)
    found.receive(7.0, 902 * MILLISECOND)
    found.reset()
    assert found.voltage(0) == CLOSED
    assert not found.present
    found.receive(6.0, 0)
    assert found.voltage(100 * MILLISECOND) == 6.0
    assert found.voltage(101 * MILLISECOND) == CLOSED
    assert counters(found) == (4, 1, 1, 1)


def test_a_new_timeout_and_closed_position_count_at_once() -> None:
    """A command in force is judged by the new timeout; the valve closes to the new position."""
    found = commands(0.1)
    found.receive(6.0, 0)
    found.configure(5.0, 0.5)
    assert found.voltage(500 * MILLISECOND) == 6.0
    found.configure(5.0, 0.2)
    assert found.voltage(500 * MILLISECOND) == 5.0
    assert found.timeouts == 1
