# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Does the carriage give where it sticks? Position against force, on courses written by hand."""

import numpy as np
import numpy.typing as npt
import pytest
from extent import some_of

from rodless_lab.identification.coverage import KNOWN, SUBJECTS, measured_run, most
from rodless_lab.identification.friction.rest import Give, give_at_rest, verdict_of
from rodless_lab.identification.friction.run import identify_friction
from rodless_lab.runs.measured_run import run_of_trace
from rodless_sim import RigParameters, simulate

Array = npt.NDArray[np.float64]

NOISE = 2e-5  # m, of a sensor
LUGRE = {"friction.dynamics": "lugre"}


def course(compliance: float, noise: float, seed: int = 1) -> tuple[Array, Array, Array]:
    """A carriage that rests for 3 s, slides for 1 s and rests again, while the force swings."""
    time = np.arange(7000) * 1e-3
    force = 20.0 * np.sin(2.0 * np.pi * time / 3.5)
    slide = 0.02 * np.clip(time - 3.0, 0.0, 1.0)
    generator = np.random.default_rng(seed)
    position = 0.05 + slide + compliance * force + noise * generator.standard_normal(len(time))
    return time, position, force


@pytest.mark.parametrize("compliance", [0.0, 1e-6, 5e-6])
def test_the_slope_of_position_on_force_is_found_within_its_error(compliance: float) -> None:
    """With 20 µm of noise, over both rests: of 300 seeds, 95 % lie within 1.96 standard errors."""
    errors = []
    for seed in range(300):
        give = give_at_rest(*course(compliance, NOISE, seed))
        assert give is not None
        errors.append((give.compliance - compliance) / give.error)
    assert np.count_nonzero(np.abs(errors) > 1.96) <= most(0.05, 300)
    assert np.std(errors) == pytest.approx(1.0, abs=0.15)


def test_without_noise_the_slope_is_exact() -> None:
    """To a millionth."""
    give = give_at_rest(*course(3e-6, 0.0))
    assert give is not None
    assert give.compliance == pytest.approx(3e-6, rel=1e-6)


def test_a_carriage_that_never_rests_says_nothing() -> None:
    """No rest, no check; such a verdict stands in nobody's way."""
    time = np.arange(3000) * 1e-3
    assert give_at_rest(time, 0.02 * time, np.sin(time)) is None
    assert verdict_of(None).checks == ()


def test_a_moment_of_rest_says_nothing() -> None:
    """60 ms at the start of a run that then moves under a rising force are no rest to judge by."""
    time = np.arange(3000) * 1e-3
    position = 0.05 + 0.05 * np.clip(time - 0.06, 0.0, None)
    assert give_at_rest(time, position, 15.0 + 3.0 * time) is None


@pytest.mark.parametrize("after", [0.0, 20.0])
def test_a_force_that_does_not_vary_says_nothing(after: float) -> None:
    """The force is constant, or jumps once beyond what may be compared with it."""
    time = np.arange(3000) * 1e-3
    noise = NOISE * np.random.default_rng(1).standard_normal(len(time))
    assert give_at_rest(time, 0.05 + noise, np.where(time < 1.5, 0.0, after)) is None


@pytest.mark.parametrize("voltages", [(5.6, 5.4, 5.7, 5.5), (6.0, 5.5, 6.5, 7.0)])
@pytest.mark.parametrize("length", [500, 1500])
def test_a_rig_that_starts_at_once_fits(voltages: tuple[float, ...], length: int) -> None:
    """Runs of the default rig that begin as the valve opens, read without noise."""
    rig = RigParameters()
    trace = simulate(rig, np.repeat(voltages, length), 1e-3, position=0.01)
    assert identify_friction(run_of_trace(trace, rig.number("supply.pressure")), rig).rest.fits


def test_the_verdict_names_the_bristles() -> None:
    """Refused from a few standard errors on, with a stiffness; not for what is stiffer than any."""
    told = verdict_of(Give(4e-6, 2e-7))
    assert not told.fits
    assert "friction.bristle_stiffness of the order of 2e+05 N/m" in str(told)
    assert verdict_of(Give(4e-7, 2e-7)).fits
    assert verdict_of(Give(-4e-6, 2e-7)).fits
    assert verdict_of(Give(1e-9, 0.0)).fits


@pytest.mark.parametrize("seed", some_of(range(3), 3))
def test_a_rig_on_bristles_is_told_from_one_that_sticks(seed: int) -> None:
    """Whole runs with the data sheet's sensors: fits, does not fit, and fits where it is stated.

    On the way to breaking loose the bristles yield, so that the slope lies between 1/σ₀ and twice
    that: x = -(F_s/σ₀) ln(1 - F/F_s) at a load F.
    """
    subject = SUBJECTS["friction"]
    stiffness = 2e5
    for changes, fits in (({}, True), ({**LUGRE, "friction.bristle_stiffness": stiffness}, False)):
        generator = np.random.default_rng(seed)
        rig, _ = subject.hide(generator)
        run = measured_run(rig.with_values(changes), subject.voltages, generator)
        fit = identify_friction(run, KNOWN)
        assert fit.rest.fits == fits, str(fit.rest)
        if not fits:
            assert 1.0 < fit.rest.checks[0].found * 1e-6 * stiffness < 2.0
            assert identify_friction(run, RigParameters({**KNOWN, **LUGRE})).rest.fits
