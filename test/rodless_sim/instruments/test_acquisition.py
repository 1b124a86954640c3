# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""When readings are taken, and how late they come."""

import numpy as np
import pytest

from rodless_base.measurement import Measurement
from rodless_sim import Rig, RigParameters
from rodless_sim.instruments.sampling import Sampling

MILLISECOND = 1_000_000


def readings(count: int = 100, **sensors: object) -> np.ndarray:
    """Positions read each ms of a truth that grows by 1 mm each, shape (count,)."""
    instruments = Sampling(RigParameters({f"sensors.{n}": v for n, v in sensors.items()}))
    return np.array(
        [
            instruments.read(Measurement(k * MILLISECOND, k * 1e-3, 4e5, 4e5, 6e5)).position
            for k in range(count)
        ]
    )


def test_without_delay_and_period_readings_are_of_their_own_instant() -> None:
    """The truth, bit for bit."""
    assert np.array_equal(readings(), [k * 1e-3 for k in range(100)])


@pytest.mark.parametrize("delay", [1e-3, 2.5e-3, 0.4e-3])
def test_a_delay_shows_what_was_before(delay: float) -> None:
    """On the line between two samples; the start before it."""
    due = np.maximum(np.arange(100) * 1e-3 - delay, 0.0)
    assert readings(delay=delay) == pytest.approx(due, abs=1e-12)


@pytest.mark.parametrize("period", [5e-3, 2.5e-3, 0.3e-3])
def test_a_slow_converter_holds_each_sample(period: float) -> None:
    """Readings are of the last multiple of its period."""
    instants = np.floor(np.arange(100) * 1e-3 / period + 1e-9) * period
    assert readings(sampling_period=period) == pytest.approx(instants, abs=1e-12)


def test_both_together_are_of_the_last_sample_that_has_arrived() -> None:
    """A sample at each 5 ms, there 2 ms later."""
    instants = np.maximum(np.floor((np.arange(100) * 1e-3 - 2e-3) / 5e-3 + 1e-9) * 5e-3, 0.0)
    found = readings(delay=2e-3, sampling_period=5e-3)
    assert found == pytest.approx(instants, abs=1e-12)


def test_a_sample_that_is_held_keeps_its_noise() -> None:
    """Five readings are equal, the next five are others."""
    found = readings(position_noise=1e-5, sampling_period=5e-3).reshape(-1, 5)
    assert np.ptp(found, axis=1).max() == 0.0
    assert len(np.unique(found[:, 0] - np.arange(20) * 5e-3)) == 20


@pytest.mark.parametrize("slow", [{"sensors.sampling_period": 0.05}, {"sensors.delay": 0.05}])
def test_what_was_true_before_a_direct_reading_is_forgotten(slow: dict[str, object]) -> None:
    """Slow, direct and slow again: never on a line from the first time to the second."""
    instruments = Sampling(RigParameters(slow))
    found = []
    for k in range(400):
        if k in (100, 217):
            instruments.configure(RigParameters(slow if k == 217 else {}))
        seen = instruments.read(Measurement(k * MILLISECOND, k * 1e-3, 4e5, 4e5, 6e5))
        found.append(seen.position)
    assert min(found[217:270]) >= 0.2
    assert found[270:] == pytest.approx(
        [k * 1e-3 - 0.05 if "sensors.delay" in slow else k // 50 * 0.05 for k in range(270, 400)],
        abs=1e-12,
    )


@pytest.mark.parametrize("slow", ["delay", "sampling_period", "pressure_lag"])
def test_another_seed_leaves_what_is_under_way(slow: str) -> None:
    """Of instruments without noise and errors of their own a seed changes nothing."""
    values = RigParameters({f"sensors.{slow}": 0.02})
    instruments, same = Sampling(values), Sampling(values)
    for k in range(100):
        if k == 50:
            instruments.configure(values.with_values({"sensors.seed": 7}))
        true = Measurement(k * MILLISECOND, k * 1e-3, 4e5 + k * 1e3, 4e5, 6e5)
        assert instruments.read(true) == same.read(true), k


def test_a_sensor_whose_fault_has_ended_reads_what_the_converter_holds() -> None:
    """At once, not only with the converter's next sample; frozen, it stays whatever the seed."""
    slow = RigParameters({"sensors.sampling_period": 1.0})
    gone = slow.with_values({"fault.position.sensor": "gone"})
    frozen = slow.with_values({"fault.position.sensor": "frozen", "sensors.sampling_period": 0.0})
    instruments, k = Sampling(slow), 0

    def read(parameters: RigParameters) -> float:
        nonlocal k
        k += 1
        instruments.configure(parameters)
        return instruments.read(Measurement(k * MILLISECOND, k * 1e-3, 4e5, 4e5, 6e5)).position

    assert read(slow) == 1e-3
    assert np.isnan(read(gone))
    assert read(slow) == 1e-3
    assert read(frozen) == 1e-3
    assert read(frozen.with_values({"sensors.seed": 7})) == 1e-3


def test_a_reset_forgets_what_was_before() -> None:
    """The run after it reads as the first."""
    rig = Rig(RigParameters({"sensors.delay": 3e-3, "sensors.pressure_lag": 2e-3}))

    def run() -> list[Measurement]:
        found = [rig.read()]
        for _ in range(50):
            rig.advance(7.0, 1e-3)
            found.append(rig.read())
        return found

    first = run()
    rig.reset()
    assert run() == first
    assert first[-1].stamp == 50 * MILLISECOND
