# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The benchmark's own arithmetic: which command answers which sample, and how late."""

import numpy as np
import pytest

from rodless_lab.benchmark.statistics import answer_times, statistics

PERIOD = 1_000_000


def traffic(delays: np.ndarray, first: int) -> tuple[np.ndarray, np.ndarray]:
    """Samples every ms; the command for each from ``first`` on, sent 50 µs before it is heard."""
    sent = np.arange(len(delays)) * PERIOD + 7_000_000_000
    heard = sent + delays
    return sent, np.stack([heard - 50_000, heard], axis=1)[first:]


@pytest.mark.parametrize("first", [0, 1, 5])
def test_each_command_is_held_against_its_own_sample(first: int) -> None:
    """Delays put in come out, also where one command comes after the next sample was sent."""
    delays = np.random.default_rng(1).integers(100_000, 600_000, 1000)
    delays[[200, 700]] = 1_700_000, 2_900_000
    sent, commands = traffic(delays, first)
    assert np.array_equal(answer_times(sent, commands), delays[first:])


def test_commands_heard_before_the_first_sample_are_left_out() -> None:
    """The answers to two samples that nobody here has seen."""
    delays = np.full(500, 300_000)
    sent, commands = traffic(delays, 0)
    assert np.array_equal(answer_times(sent[2:], commands), delays[2:])


def test_statistics_of_a_known_row() -> None:
    """0 to 1000 ms: mean and quantiles by hand."""
    found = statistics("x", np.arange(1001.0))
    assert list(found.values()) == pytest.approx([500.0, 500.0, 990.0, 999.0, 1000.0])
    assert list(found) == [f"x, {name} (ms)" for name in ("mean", "p50", "p99", "p99.9", "worst")]
