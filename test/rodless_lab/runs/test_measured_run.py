# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A run made by hand: what cannot be its columns is refused by name."""

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pandas as pd
import pytest

from rodless_lab import MeasuredRun
from rodless_lab.runs.measured_run import RunError

TIME = np.arange(100) * 1e-3
STILL = np.full(100, 4e5)


@pytest.mark.parametrize("name", ["time", "position", "voltage"])
@pytest.mark.parametrize(
    "values", [TIME.tolist(), None, 1.0, np.array(1.0), np.array(["a"] * 100), STILL[None]]
)
def test_a_column_that_is_no_array_of_numbers_is_refused(name: str, values: object) -> None:
    """Lists, single numbers, texts and tables: one line that names the column."""
    columns = dict.fromkeys(("time", "position", "pressure_a", "pressure_b"), STILL)
    columns |= {"time": TIME, "supply_pressure": STILL, "voltage": STILL / 1e5}
    assert MeasuredRun(**columns).period == pytest.approx(1e-3)
    with pytest.raises(RunError, match=f"^{name}: .* refused, must be an array of numbers$"):
        MeasuredRun(**{**columns, name: values})  # type: ignore[arg-type]


@pytest.mark.parametrize("share", [0.4, -0.5, 0.9])
def test_a_sample_out_of_step_is_named(share: float) -> None:
    """All that is computed from a run takes its samples as evenly spaced."""
    late = np.where(np.arange(100) == 40, share * 1e-3, 0.0)
    step = 1e-3 * (1.0 + share)
    said = f"^time: sample 40 comes {step:.6g} s after the one before, mostly it is 0.001 s"
    with pytest.raises(RunError, match=said):
        MeasuredRun(TIME + late, *[STILL] * 5)


@pytest.mark.parametrize("gap", [1, 3, 50_000])
@pytest.mark.parametrize("place", [1, 40, 98])
def test_a_gap_is_named_wherever_it_is(gap: int, place: int) -> None:
    """Samples that are missing: not the first one is blamed, whose step is not the mean."""
    time = np.where(np.arange(100) >= place, TIME + gap * 1e-3, TIME)
    with pytest.raises(RunError, match=f"^time: sample {place} comes {1e-3 * (1 + gap):.6g} s aft"):
        MeasuredRun(time, *[STILL] * 5)


@pytest.mark.parametrize(
    "time",
    [
        np.round(np.arange(100) / 300.0, 3),  # 300 Hz in whole ms
        1.7e9 + np.arange(100) / 50_000.0,  # since 1970
        TIME + 2e-4 * np.random.default_rng(1).uniform(-1.0, 1.0, 100),  # a timer that jitters
    ],
    ids=["rounded", "epoch", "jitter"],
)
def test_stamps_may_be_rounded_and_jitter(time: np.ndarray) -> None:
    """It does not add up: the period is right."""
    assert MeasuredRun(time, *[STILL] * 5).period == pytest.approx((time[-1] - time[0]) / 99)


@pytest.mark.parametrize("other", [np.longdouble, np.dtype(np.float64).newbyteorder()])
def test_reals_of_other_kinds_are_made_native_ones(tmp_path: Path, other: npt.DTypeLike) -> None:
    """Solvers, tables and compiled kernels know no others, such as a logger's of another order."""
    run = MeasuredRun(TIME.astype(other), *[STILL.astype(other)] * 5)
    assert {values.dtype for values in run.columns().values()} == {np.dtype(np.float64)}
    assert all(values.dtype.isnative for values in run.columns().values())
    assert run.time.tolist() == TIME.tolist()
    run.save(tmp_path / "run.parquet")
    assert pd.read_parquet(tmp_path / "run.parquet").to_numpy()[:, 0].tolist() == TIME.tolist()


def test_short_reals_are_made_longer_ones() -> None:
    """Half precision holds 0.25 m and 5 V exactly."""
    half = np.full(100, 0.25, dtype=np.float16)
    run = MeasuredRun(TIME, half, STILL, STILL, STILL, np.full(100, 5.0, dtype=np.float16))
    assert (run.position.dtype, run.voltage.dtype) == (np.float64, np.float64)
    assert (run.position[0], run.voltage[0]) == (0.25, 5.0)


def test_whole_numbers_are_made_real_ones() -> None:
    """Without a sign they have no difference below 0, and friction of it would be nonsense."""
    pascal = np.full(100, 400_000, dtype=np.uint32)
    run = MeasuredRun(TIME, STILL / 4e6, pascal, pascal + 1, STILL, STILL / 1e5)
    assert float((run.pressure_a - run.pressure_b)[0]) == -1.0
    with pytest.raises(RunError, match="time does not increase at sample 2"):
        MeasuredRun(np.array([5, 8, 3] * 40, dtype=np.uint64)[:100], *[STILL] * 5)
