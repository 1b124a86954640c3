# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The numbers engineers quote of a step response."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

# The paper's positioning tolerance (section 7): 0.2 mm.
SETTLING_BAND = 2e-4


@dataclass(frozen=True)
class StepMetrics:
    """Of a move between two positions: s, s, m, m, V, V. A time is NaN if it never came."""

    rise_time: float
    settling_time: float
    overshoot: float
    final_error: float
    peak_voltage: float  # the highest
    lowest_voltage: float


def step_metrics(
    time: Array, position: Array, voltage: Array, start: float, target: float, at: float
) -> StepMetrics:
    """Measure the response to a step from ``start`` to ``target`` (m) at time ``at`` (s).

    ``time`` (s, increasing) and ``position`` (m) have one shape (n,); ``voltage`` (V) may have
    another. Rise time is from 10 to 90 % of the step; settling is the last entry into ±0.2 mm;
    overshoot is past the target, 0 if there is none; the final error is the last position minus the
    target. Raises ValueError for an empty record, one that is not finite, or a step of no height.
    """
    if not len(time) or not len(voltage) or start == target:
        raise ValueError("a step response needs samples and a step")
    if not all(np.isfinite(values).all() for values in (time, position, voltage)):
        raise ValueError("a step response needs samples that are finite")
    share = (position - start) / (target - start)
    outside = np.flatnonzero(np.abs(position - target) > SETTLING_BAND)
    settled = outside[-1] + 1 if len(outside) else 0
    return StepMetrics(
        rise_time=_first(time, share >= 0.9) - _first(time, share >= 0.1),
        settling_time=max(float(time[settled]) - at, 0.0) if settled < len(time) else np.nan,
        overshoot=float(max(share.max() - 1.0, 0.0) * abs(target - start)),
        final_error=float(position[-1] - target),
        peak_voltage=float(voltage.max()),
        lowest_voltage=float(voltage.min()),
    )


def metric_lines(metrics: StepMetrics) -> list[str]:
    """Return the metrics as lines of a table, positions in mm; a dash for what never came."""
    rows = (
        ("rise time 10-90 %", metrics.rise_time, "s"),
        ("settling time to ±0.2 mm", metrics.settling_time, "s"),
        ("overshoot", metrics.overshoot * 1e3, "mm"),
        # A controller's error is reference minus position: the opposite sign.
        ("final error, actual - target", metrics.final_error * 1e3, "mm"),
        ("peak valve voltage, highest", metrics.peak_voltage, "V"),
        ("peak valve voltage, lowest", metrics.lowest_voltage, "V"),
    )
    return [
        f"{label:28}{'-' if np.isnan(value) else f'{value:.3f}':>12} {unit}"
        for label, value, unit in rows
    ]


def _first(time: Array, reached: npt.NDArray[np.bool_]) -> float:
    return float(time[np.argmax(reached)]) if reached.any() else np.nan
