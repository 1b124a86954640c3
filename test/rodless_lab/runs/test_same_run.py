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


def run(seed: int, noise: float = 200.0, rest: int = 0) -> MeasuredRun:
    """Pressures that swing, after ``rest`` samples that stay; sensors of 16 bit with ``noise``."""
    generator, time = np.random.default_rng(seed), np.arange(2000) * 1e-3
    swing = 4e5 + 1e5 * np.sin(2.0 * np.pi * np.maximum(time - rest * 1e-3, 0.0) * (1.0 + seed))
    pressure = 15.0 * np.round((swing + generator.normal(0.0, noise, 2000)) / 15.0)
    return MeasuredRun(time, time, pressure, pressure, pressure, time)


def part(whole: MeasuredRun, kept: np.ndarray) -> MeasuredRun:
    """Return a run of the samples that are ``kept``."""
    return replace(whole, **{name: values[kept] for name, values in whole.columns().items()})


@pytest.mark.parametrize("noise", [0.0, 200.0])
def test_what_is_of_a_known_run_is_known(noise: float) -> None:
    """All of it, all but a sample in a hundred, and its second half."""
    known, samples = run(1, noise), np.arange(2000)
    for kept in (samples, samples[samples % 100 != 7], samples[1000:]):
        assert mostly_known(part(known, kept), known)


@pytest.mark.parametrize("noise", [0.0, 5.0, 200.0])
def test_another_run_of_the_rig_is_not(noise: float) -> None:
    """Even where both rest for most of the time, at the same pressure."""
    assert not mostly_known(run(2, noise, rest=1800), run(3, noise, rest=1800))
    assert not mostly_known(run(2, noise), run(3, noise))
