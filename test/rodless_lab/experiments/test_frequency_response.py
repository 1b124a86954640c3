# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The frequency response: what it measures on a system whose response is known."""

import dataclasses

import numpy as np
import pytest

from rodless_lab.experiments import frequency_response as experiment


def test_a_model_of_another_voltage_does_not_pass() -> None:
    """The limits tell a wrong linear model: gain at 6 V is another than at 5.5 V."""
    found = experiment.respond("paper", seed=2)
    assert all(row.holds for row in experiment.FrequencyResponse({"paper": found}).comparisons)
    other = experiment.linearise(experiment.RigParameters.preset("paper"), 0.1, 6.0)
    expected = other.sampled_response(experiment.LINES, experiment.SAMPLE_PERIOD, "velocity")
    wrong = dataclasses.replace(found, expected=expected)
    rows = experiment.FrequencyResponse({"paper": wrong}).comparisons
    assert [row.holds for row in rows] == [True, False, False]


def test_excitation_has_the_lines_and_the_size_it_says() -> None:
    """All of its power stands at LINES, and its root mean square is AMPLITUDE."""
    count = round(experiment.REPETITION / experiment.SAMPLE_PERIOD)
    drawn = experiment.random_phases(np.random.default_rng(0), count)
    assert np.sqrt(np.mean(drawn**2)) == pytest.approx(experiment.AMPLITUDE, rel=1e-9)
    at_lines = np.abs(experiment.spectrum(drawn)) ** 2
    everything = np.abs(np.fft.rfft(drawn)) ** 2
    assert at_lines.sum() == pytest.approx(everything.sum(), rel=1e-9)
