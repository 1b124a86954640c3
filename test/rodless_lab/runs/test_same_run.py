# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A run that is known already is told from another of the same rig."""

from dataclasses import replace

import numpy as np
import pytest

from rodless_lab.runs.measured_run import MeasuredRun
from rodless_lab.runs.same_run import mostly_known


def run(seed: int, noise: float = 200.0, rest: int = 0, step: float = 15.0) -> MeasuredRun:
    """Pressures that swing after ``rest`` samples, read in ``step`` and with ``noise`` (Pa).

    The carriage goes along, read to 5 µm.
    """
    generator, time = np.random.default_rng(seed), np.arange(2000) * 1e-3
    swing = np.sin(2.0 * np.pi * np.maximum(time - rest * 1e-3, 0.0) * (1.0 + 0.3 * seed))
    a, b = (
        step * np.rint((4e5 + sign * 1e5 * swing + generator.normal(0.0, noise, 2000)) / step)
        for sign in (1.0, -1.0)
    )
    return MeasuredRun(time, 5e-6 * np.rint((0.1 + 0.02 * swing) / 5e-6), a, b, a, time)


def part(whole: MeasuredRun, kept: np.ndarray) -> MeasuredRun:
    """Return a run of the samples that are ``kept``."""
    return replace(whole, **{name: values[kept] for name, values in whole.columns().items()})


SENSORS = pytest.mark.parametrize(
    ("step", "noise"), [(15.0, 0.0), (15.0, 5.0), (12.5, 200.0), (1220.0, 20.0), (1220.0, 0.0)]
)


@SENSORS
def test_what_is_of_a_known_run_is_known(step: float, noise: float) -> None:
    """All of it, with a sample in twenty lost, every second one, its second half, another clock."""
    known, samples = run(1, noise, step=step), np.arange(2000)
    for kept in (samples, samples[::2], samples[1000:]):
        assert mostly_known(part(known, kept), known)
    # A reader puts the value of its neighbour in place of one that was lost.
    held = np.where(samples % 20 == 7, samples - 1, samples)
    lossy = {name: values[held] for name, values in known.columns().items()}
    assert mostly_known(replace(known, **{**lossy, "time": known.time}), known)
    late = replace(known, time=known.time + 0.37)
    assert mostly_known(part(late, samples[500:]), known)


@SENSORS
def test_another_run_of_the_rig_is_not(step: float, noise: float) -> None:
    """Even where both rest for most of the time, at the same pressure."""
    for rest in (0, 1000, 1800):
        assert not mostly_known(run(2, noise, rest, step), run(3, noise, rest, step))
