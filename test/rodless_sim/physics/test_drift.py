# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Friction that drifts: its statistics, and that a seed gives the same run everywhere."""

import math

import numpy as np
import numpy.typing as npt
import pytest

from rodless_control import PidParameters, references
from rodless_lab import closed_loop
from rodless_sim import Rig, RigParameters, simulate
from rodless_sim.physics.drift import STEP, Drift, first_dice, stepped, thrown

Array = npt.NDArray[np.float64]

MODULI = (30269, 30307, 30323)

step_once = getattr(stepped, "py_func", stepped)
throw = getattr(thrown, "py_func", thrown)


def walks(size: float, time: float, seconds: float, seeds: range) -> Array:
    """The deviations of each seed after every 10 ms: shape (seeds, steps, 3)."""
    found = []
    for seed in seeds:
        values = {"friction.drift": size, "friction.drift_time": time, "friction.drift_seed": seed}
        drift = Drift.of(RigParameters(values))
        dice, now = first_dice(seed), np.zeros(3)
        rows = []
        for _ in range(round(seconds / STEP)):
            dice = step_once(drift, dice, now)
            rows.append(now.copy())
        found.append(rows)
    return np.array(found)


def test_dice_are_those_of_wichmann_and_hill() -> None:
    """The first numbers from 1, 2, 3, worked out with fractions as the algorithm is printed."""
    words = [1, 2, 3]
    dice = float(words[0] + 30269 * (words[1] + 30307 * words[2]))
    for _ in range(50):
        words = [a * b % m for a, b, m in zip((171, 172, 170), words, MODULI, strict=True)]
        expected = sum(b / m for b, m in zip(words, MODULI, strict=True)) % 1.0
        dice, number = throw(dice)
        assert number == pytest.approx(expected, abs=1e-12)


def test_spread_grows_with_the_root_of_time() -> None:
    """After 1 s it is friction.drift, after 0.25 s half: 300 seeds, three walks each."""
    found = walks(0.05, 1e6, 1.0, range(300))
    for seconds in (0.25, 1.0):
        ends = found[:, round(seconds / STEP) - 1]
        assert ends.std() == pytest.approx(0.05 * math.sqrt(seconds), rel=0.08)
        assert abs(ends.mean()) < 3.0 * ends.std() / math.sqrt(ends.size)
    correlations = np.corrcoef(found[:, -1].T)
    assert np.abs(correlations - np.eye(3)).max() < 0.2


def test_in_the_end_the_spread_stays() -> None:
    """Much later than τ = 1 s it is s √(τ/2), and what it was 1 s before counts by 1/e."""
    walk = walks(0.05, 1.0, 120.0, range(8))[:, 500:]
    assert walk.std() == pytest.approx(0.05 * math.sqrt(0.5), rel=0.12)
    lag = round(1.0 / STEP)
    correlation = np.mean(walk[:, :-lag] * walk[:, lag:]) / np.mean(walk**2)
    assert correlation == pytest.approx(math.exp(-1.0), abs=0.15)


DRIFTING = RigParameters({"friction.drift": 0.1})


def test_a_run_drifts_and_a_reset_repeats_it() -> None:
    """Every 10 ms three numbers change; after a reset they change in the same way."""
    rig = Rig(DRIFTING)
    first = [rig.advance(6.0, 1e-3) for _ in range(60)]
    rig.reset()
    assert [rig.advance(6.0, 1e-3) for _ in range(60)] == first
    drifts = np.array([[s.static_drift, s.coulomb_drift, s.viscous_drift] for s in first])
    changes = np.flatnonzero(np.diff(drifts[:, 0])) + 2
    assert changes.tolist() == [10, 20, 30, 40, 50, 60]
    other = Rig(DRIFTING.with_values({"friction.drift_seed": 2}))
    later = other.advance(6.0, 0.06)
    assert later.static_drift != first[-1].static_drift


def test_friction_is_what_it_has_drifted_to() -> None:
    """A carriage breaks away at F_s e^w, w being what the state shows."""
    values = {"friction.drift": 0.3, "friction.drift_seed": 3, "friction.forward.coulomb": 0.0}
    rig = Rig(RigParameters(values))
    rig.reset(position=0.1)
    before = state = rig.state
    while state.velocity == 0.0:
        before, state = state, rig.advance(5.3, 1e-3)
    low, high = sorted(29.0 * math.exp(s.static_drift) for s in (before, state))
    # It changes by some 0.9 N at a time.
    assert low - 1.5 < state.force
    assert before.force < high + 1.5
    assert abs(29.0 * math.exp(state.static_drift) - 29.0) > 3.0


def test_everywhere_the_same_bits() -> None:
    """Step by step, in one call and in closed loop, with the same commands."""
    law = PidParameters.preset("calibrated")
    run = closed_loop(DRIFTING, law, references.step(0.0, 0.02, at=0.01), 0.2, 1e-3)
    whole = simulate(DRIFTING, run.voltage[:-1], 1e-3)
    rig = Rig(DRIFTING)
    steps = [rig.advance(voltage, 1e-3) for voltage in run.voltage[:-1].tolist()]
    for name in ("position", "static_drift", "viscous_drift"):
        column = getattr(whole, name)
        assert np.array_equal(column, getattr(run, name))
        assert np.array_equal(column[1:], [getattr(state, name) for state in steps])
    assert run.position[-1] > 1e-3
