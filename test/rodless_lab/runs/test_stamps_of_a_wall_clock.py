# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Bags whose stamps are of the wall clock, jitter, or lie far from zero."""

from pathlib import Path

import numpy as np
import pytest
from extent import some_of
from rig_bag import Message, write

from rodless_lab import read_commands, read_run
from rodless_lab.runs.from_bag import _period
from rodless_lab.runs.measured_run import MeasuredRun, run_of_trace
from rodless_lab.runs.resimulate import resimulate
from rodless_lab.view.playback import open_tape
from rodless_sim import RigParameters, simulate

RIG = RigParameters()
SUPPLY = RIG.number("supply.pressure")
NOW = 1_764_218_000_123_456_789  # ns since 1970
FIELDS = ("position", "pressure_a", "pressure_b", "supply_pressure", "voltage")


def moved(samples: int = 2000) -> MeasuredRun:
    """A run to and fro, with another voltage at each sample."""
    voltages = 5.08 + 0.9 * np.sin(2.0 * np.pi * 0.5e-3 * np.arange(samples))
    return run_of_trace(simulate(RIG, voltages, 1e-3, position=0.05), SUPPLY)


@pytest.mark.parametrize("held", [True, False], ids=["valve/state", "commands"])
@pytest.mark.parametrize("origin", some_of([NOW, 7_200_000_000_000], 2))
def test_it_does_not_matter_when_a_run_was_recorded(
    tmp_path: Path, origin: int, held: bool
) -> None:
    """Readings, voltages and set-points are to the bit those of a bag that begins at zero."""
    run = moved()
    paths = [
        write(tmp_path / str(k), run, setpoint=(1.0, 0.07), held=held, origin=begin)
        for k, begin in enumerate((0, origin))
    ]
    first, second = map(read_run, paths)
    assert second.notes == first.notes == ()
    assert second.time == pytest.approx(first.time, abs=1e-9)
    for name in FIELDS:
        assert np.array_equal(getattr(second, name), getattr(first, name)), name
    assert np.array_equal(second.position, run.position)
    again = resimulate(RIG, second, pressures=(run.pressure_a[0], run.pressure_b[0]))
    assert again.position == pytest.approx(run.position, abs=1e-9)
    commands = [read_commands(path) for path in paths]
    assert np.array_equal(commands[0].sample, commands[1].sample)
    tapes = [open_tape(path) for path in paths]
    columns = [tape.columns[1:] for tape in tapes]
    assert np.allclose(*columns, rtol=1e-9, atol=1e-9, equal_nan=True)  # of speeds, too


@pytest.mark.parametrize("origin", [0, NOW])
@pytest.mark.parametrize("lost", some_of([0.1, 0.0], 2))
def test_jitter_of_stamps_leaves_the_period(tmp_path: Path, origin: int, lost: float) -> None:
    """Stamps that are off by 50 µs and samples that are missing: as many samples, as far apart."""
    run = moved(5000)
    generator = np.random.default_rng(5)
    late = generator.normal(0.0, 50e-6, len(run.time))
    late[[0, -1]] = 0.0
    away = generator.random(len(run.time)) < lost
    away[[0, -1]] = False

    def shaken(_topic: str, sample: int, time: float, value: float) -> Message | None:
        return None if away[sample] else (max(time + float(late[sample]), 0.0), value)

    found = read_run(write(tmp_path / "bag", run, shaken, held=True, origin=origin))
    assert len(found.time) == len(run.time)
    assert found.period == pytest.approx(1e-3, rel=1e-9)
    assert found.position == pytest.approx(run.position, abs=1e-4)


def test_the_period_is_found_whatever_is_lost_and_however_stamps_jitter() -> None:
    """Of 300 recordings each has as many samples as there were, up to 0.3 of them lost."""
    for seed in range(300):
        draw = np.random.default_rng(seed)
        count, period = int(draw.integers(50, 20_000)), 10.0 ** draw.uniform(-3.3, -1.0)
        jitter, lost = draw.uniform(0.0, 0.1) * period, draw.uniform(0.0, 0.3)
        stamps = period * np.arange(count) + draw.normal(0.0, jitter, count)
        stamps = np.maximum.accumulate(stamps[draw.random(count) >= lost])
        length = stamps[-1] - stamps[0]
        assert round(length / _period(stamps)) == round(length / period), seed
