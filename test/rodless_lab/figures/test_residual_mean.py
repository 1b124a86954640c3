# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The thick line of the residuals: a mean over what there is, up to both ends."""

from statistics import fmean
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from rodless_lab.figures.identification import draw_bristles, draw_pressures, moving_mean


@pytest.mark.parametrize("count", [1, 4, 5, 20, 50])
def test_it_is_the_mean_of_the_values_in_its_window(count: int) -> None:
    """By slices of a list: half a window before, half behind, cut where the run begins and ends."""
    values = np.random.default_rng(1).normal(size=30).tolist()
    width = min(count, len(values))
    starts = [place - width // 2 for place in range(len(values))]
    expected = [fmean(values[max(start, 0) : start + width]) for start in starts]
    assert moving_mean(np.array(values), count) == pytest.approx(expected)


def test_a_residual_that_is_the_same_throughout_is_drawn_so() -> None:
    """7 µm and 3 kPa from the first sample to the last; it fell to half of that at both ends."""
    time = np.arange(200) * 1e-3
    still = np.zeros(200)
    run: Any = SimpleNamespace(
        time=time, period=1e-3, position=still + 7e-6, pressure_a=still + 3e3, pressure_b=still
    )
    fit: Any = SimpleNamespace(
        verdict=SimpleNamespace(fits=True), position=still, pressure_a=still, pressure_b=still
    )
    for figure, expected in ((draw_bristles(run, fit), 7.0), (draw_pressures(run, fit), 3.0)):
        lines = figure.axes[1].lines
        mean = next(line for line in lines if str(line.get_label()).endswith("mean of 20 ms"))
        assert mean.get_ydata() == pytest.approx(np.full(200, expected))
