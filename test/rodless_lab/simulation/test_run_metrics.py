# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The figures of a run against runs made by hand, of which each figure is known."""

import math

import numpy as np
import numpy.typing as npt
import pytest

from rodless_control import PidParameters, references
from rodless_control.trajectory import Trajectory, Waypoint
from rodless_lab import ClosedLoopTrace, RunMetrics, closed_loop, ensemble, run_metrics
from rodless_lab.runs.step_metrics import step_metrics
from rodless_lab.simulation.run_metrics import settled
from rodless_sim import RigParameters, simulate

Array = npt.NDArray[np.float64]

PERIOD = 1e-2
TIME = PERIOD * np.arange(401)  # 4 s


def made(reference: Array, position: Array, **columns: Array) -> ClosedLoopTrace:
    """A run of these columns; what is not given is zero."""
    zero = np.zeros(len(reference))
    time = PERIOD * np.arange(len(reference))
    names = ("velocity", "pressure_a", "pressure_b", "voltage", "force")
    found = dict.fromkeys((*names, "mass_flow_a", "mass_flow_b"), zero)
    found |= {"time": time, "position": position, "reference": reference}
    return ClosedLoopTrace(**{**found, "error": reference - position, **columns})


def stepped(at: int, height: float, count: int = 401) -> Array:
    """A reference that jumps at sample ``at``."""
    return np.where(np.arange(count) < at, 0.0, height)


def test_the_settling_time_counts_from_the_last_change_of_the_reference() -> None:
    """Whatever the carriage did before: here it enters the band 0.7 s after the second step."""
    reference = stepped(50, 0.02) + stepped(200, 0.03)
    position = np.where(np.arange(401) < 270, 0.0, 0.05 - 1.9e-4)
    assert run_metrics(made(reference, position)).settling_time == pytest.approx(0.7)


def test_a_move_settles_from_its_start_on() -> None:
    """The reference moves from 1 s to 2 s, and the carriage arrives half a second later."""
    reference = np.clip((TIME - 1.0) * 0.05, 0.0, 0.05)
    position = np.where(np.arange(401) < 250, 0.0, 0.05)
    assert run_metrics(made(reference, position)).settling_time == pytest.approx(
        1.5, abs=2 * PERIOD
    )


@pytest.mark.parametrize("end", [3.0e-4, -3.0e-4])
def test_a_carriage_beside_its_target_never_settles(end: float) -> None:
    """It is 0.3 mm off; and one that leaves the band at the last sample has not settled either."""
    reference = stepped(100, 0.05)
    assert math.isnan(run_metrics(made(reference, reference + end)).settling_time)
    position = reference.copy()
    position[-1] += end
    assert math.isnan(run_metrics(made(reference, position)).settling_time)


@pytest.mark.parametrize("height", [0.05, -0.05])
def test_overshoot_is_in_the_direction_of_the_step(height: float) -> None:
    """2 mm past the target counts, 3 mm on the near side does not."""
    reference = stepped(100, height)
    position = reference.copy()
    position[150], position[160] = height * 1.04, height * 0.94
    assert run_metrics(made(reference, position)).overshoot == pytest.approx(2e-3)


@pytest.mark.parametrize("begin", [0.02, 0.14, 0.08])
def test_overshoot_of_a_reference_that_never_changes(begin: float) -> None:
    """The carriage comes from one side: what is past the reference counts, 3 mm before it does not.

    From the reference itself no side is the far one, and there is no overshoot.
    """
    reference = np.full(401, 0.08)
    position = reference.copy()
    position[:100] = begin
    side = np.sign(0.08 - begin)
    position[150], position[160] = 0.08 + 2e-3 * side, 0.08 - 3e-3 * side
    found = run_metrics(made(reference, position))
    assert found.overshoot == pytest.approx(2e-3 * abs(side), abs=1e-15)
    assert found.settling_time == pytest.approx(1.61 if side else 0.0)


@pytest.mark.parametrize("begin", [0.0, 0.15])
def test_a_step_at_the_start_overshoots_as_its_carriage_does(begin: float) -> None:
    """`references.step(a, b)` begins at 0: the overshoot is the farthest place past b, less b.

    A single run, an ensemble, the compiled function and the same function in plain Python agree.
    """
    step, rig = references.step(begin, 0.058), RigParameters({"cylinder.initial_position": begin})
    law = PidParameters({"controller.kp": 2000.0, "controller.kd": 0.0})
    run = closed_loop(rig, law, step, 2.0, 1e-3)
    assert np.ptp(run.reference) == 0.0
    side = np.sign(0.058 - begin)
    past = float((side * (run.true_position - 0.058)).max())
    assert past > 1e-3
    assert run_metrics(run).overshoot == past
    rows = ensemble([rig, rig], law, step, 2.0, 1e-3)
    assert rows["overshoot"].tolist() == [past, past]
    plain = getattr(settled, "py_func", settled)(run.reference, run.true_position, 1e-3)
    assert plain == pytest.approx(settled(run.reference, run.true_position, 1e-3), nan_ok=True)
    assert plain[1] == past
    later = closed_loop(rig, law, references.step(begin, 0.058, at=0.1), 2.1, 1e-3)
    assert run_metrics(later).overshoot == pytest.approx(past, rel=0.05)


def way_through(*points: tuple[float, float]) -> Array:
    """A reference in straight lines through times (s) and positions (m)."""
    times, places = np.transpose(points)
    return np.interp(TIME, times, places)


@pytest.mark.parametrize("mirror", [1.0, -1.0])
@pytest.mark.parametrize("way", ["linear", "cubic", "cubic, rounded"])
def test_overshoot_counts_from_where_the_reference_turned(mirror: float, way: str) -> None:
    """From 20 to 100 and on to 50 mm without a rest: 0.8 mm below 50 count, the way back does not.

    The same where a reference that is computed ends a rounding error off.
    """
    reference = way_through((0.0, 0.02), (0.5, 0.02), (1.5, 0.1), (2.5, 0.05))
    if way != "linear":
        up, down = np.clip(TIME - 0.5, 0.0, 1.0), np.clip(TIME - 1.5, 0.0, 1.0)
        smooth = [3.0 * share**2 - 2.0 * share**3 for share in (up, down)]
        reference = 0.02 + 0.08 * smooth[0] - 0.05 * smooth[1]
        reference[TIME >= 2.5] = reference[-1]
    if way == "cubic, rounded":
        last = int(np.searchsorted(TIME, 2.5))
        reference[last - 1] = reference[-1] - 1e-17 * 8.0
        reference[last - 2] = reference[-1] + 1e-15
    position = np.concatenate([reference[:5], reference[:-5]])
    position[300:310] -= 0.8e-3
    position[320:330] += 1.5e-3
    found = run_metrics(made(mirror * reference, mirror * position))
    assert found.overshoot == pytest.approx(0.8e-3, rel=1e-6)


def test_overshoot_where_the_reference_ends_where_it_began() -> None:
    """From 20 to 100 and back to 20 mm without a rest: 5 mm below 20 count."""
    reference = way_through((0.0, 0.02), (0.5, 0.02), (1.5, 0.1), (2.5, 0.02))
    position = reference.copy()
    position[300] -= 5e-3
    assert run_metrics(made(reference, position)).overshoot == pytest.approx(5e-3)


def test_overshoot_of_a_carriage_that_never_got_to_the_turn() -> None:
    """The reference goes to 100 mm for a moment, then to 50: a carriage at 0 comes from below."""
    reference = way_through((0.0, 0.0), (0.5, 0.0), (0.51, 0.1), (0.52, 0.05))
    position = np.minimum(0.05 * np.clip(TIME - 0.5, 0.0, 1.0), 0.05)
    position[200] = 0.052
    assert run_metrics(made(reference, position)).overshoot == pytest.approx(2e-3)


def test_overshoot_of_a_real_way_out_and_back() -> None:
    """Along waypoints: the farthest that the carriage gets past the last."""
    way = Trajectory([Waypoint(0.5, 0.02), Waypoint(1.5, 0.1), Waypoint(2.5, 0.05)])
    rig, law = RigParameters.preset("calibrated"), PidParameters.preset("calibrated")
    run = closed_loop(rig, law, way, 4.0, 1e-3, 0.02)
    past = float((0.05 - run.true_position[1501:]).max())
    assert 1e-4 < past < 2e-3
    assert run_metrics(run).overshoot == pytest.approx(past, abs=1e-12)
    plain = getattr(settled, "py_func", settled)(run.reference, run.true_position, 1e-3)
    assert plain == settled(run.reference, run.true_position, 1e-3)


def test_two_equal_samples_of_a_sine_are_no_rest() -> None:
    """A crest between the last two samples, which are equal to the last bit: it still moves."""
    sine = references.sine(0.1, 0.02, 0.5, 0.1005)
    run = closed_loop(RigParameters(), PidParameters(), sine, 0.601, 1e-3)
    assert run.reference[-1] == run.reference[-2]
    found = run_metrics(run)
    assert math.isnan(found.settling_time)
    assert math.isnan(found.overshoot)


@pytest.mark.parametrize(
    ("reference", "settling"),
    [
        ([0.0, 0.0, 0.05, 0.05], 0.0),  # a step one interval ago
        ([0.0, 0.05, 0.05], 0.0),
        ([0.05, 0.05], 0.0),
        ([0.0, 0.02, 0.05, 0.05, 0.05], 0.0),  # a move that has ended
        ([0.0, 0.02, 0.05, 0.05], math.nan),  # one that may turn
        ([0.0, 0.0, 0.05], math.nan),
    ],
)
def test_a_short_run_rests_where_its_reference_does(
    reference: list[float], settling: float
) -> None:
    """A carriage that is always on the reference has settled at once, if that is at rest."""
    wanted = np.array(reference)
    found = run_metrics(made(wanted, wanted))
    assert found.settling_time == pytest.approx(settling, nan_ok=True)
    assert math.isnan(found.overshoot) == math.isnan(settling)


def test_what_still_moves_neither_settles_nor_overshoots() -> None:
    """A sine has its errors, but no settling time."""
    reference = 0.1 + 0.02 * np.sin(2.0 * np.pi * 0.5 * TIME)
    found = run_metrics(made(reference, reference - 1e-3))
    assert math.isnan(found.settling_time)
    assert math.isnan(found.overshoot)
    assert found.peak_error == pytest.approx(1e-3)
    assert found.rms_error == pytest.approx(1e-3)
    assert found.mean_error == pytest.approx(1e-3)


def test_peak_and_rms_count_from_the_time_given() -> None:
    """The jump of a step is left out; the error behind it counts."""
    reference = stepped(100, 0.05)
    position = np.where(np.arange(401) < 150, 0.0, 0.05 - 1e-3)
    found = run_metrics(made(reference, position), since=1.5)
    assert found.peak_error == pytest.approx(1e-3)
    assert found.rms_error == pytest.approx(1e-3)
    assert run_metrics(made(reference, position)).peak_error == 0.05
    with pytest.raises(ValueError, match=r"^since 5 s refused: the run is from 0 to 4 s$"):
        run_metrics(made(reference, position), since=5.0)
    with pytest.raises(ValueError, match=r"^since -1 s refused: the run is from 0 to 4 s$"):
        run_metrics(made(reference, position), since=-1.0)


def test_a_limit_cycle_is_seen_in_the_last_second() -> None:
    """0.3 mm about a mean of 0.1 mm, and nothing of what was before."""
    wave = 1e-4 + 3e-4 * np.sin(2.0 * np.pi * 4.0 * TIME)
    reference = np.full(401, 0.05)
    position = reference - np.where(np.arange(401) < 300, 5e-3, wave)
    found = run_metrics(made(reference, position))
    assert found.limit_cycle == pytest.approx(3e-4, rel=1e-2)
    assert found.mean_error == pytest.approx(1e-4, rel=2e-2)
    assert found.final_error == pytest.approx(wave[-1])


def test_air_counts_what_flows_in_and_the_valve_both_directions() -> None:
    """1 g/s into A for a second, out of it for another; the command goes up 2 V and down 1 V."""
    flow = np.zeros(401)
    flow[100:200], flow[200:300] = 1e-3, -1e-3
    voltage = 5.0 + stepped(100, 2.0) - stepped(200, 1.0)
    zero = np.zeros(401)
    found = run_metrics(made(zero, zero, mass_flow_a=flow, voltage=voltage))
    assert found.air == pytest.approx(1e-3)
    assert found.valve_travel == pytest.approx(3.0)
    assert (found.rest_voltage, found.chatter) == pytest.approx((0.0, 0.0), abs=1e-12)


def test_chatter_at_rest_is_told_from_a_slow_wave() -> None:
    """0.1 V up and down at each sample; a wave of a second has the same RMS, but hardly changes."""
    zero = np.zeros(401)
    chatter = 5.0 + 0.1 * (-1.0) ** np.arange(401)
    found = run_metrics(made(zero, zero, voltage=chatter))
    assert (found.rest_voltage, found.chatter) == pytest.approx((0.1, 0.2), rel=1e-3)
    wave = 5.0 + 0.1 * np.sqrt(2.0) * np.sin(2.0 * np.pi * TIME)
    found = run_metrics(made(zero, zero, voltage=wave))
    assert found.rest_voltage == pytest.approx(0.1, rel=1e-2)
    assert found.chatter < 0.01


def test_a_real_step_has_the_figures_of_the_step_metrics() -> None:
    """As `rodless demo` measures them, by a reader that knows where the step is."""
    step = references.step(0.0, 0.058, at=0.5)
    run = closed_loop(RigParameters(), PidParameters(), step, 6.0, 1e-3)
    found = run_metrics(run)
    other = step_metrics(run.time, run.position, run.voltage, 0.0, 0.058, 0.5)
    assert found.settling_time == pytest.approx(other.settling_time, abs=1e-9)
    assert found.overshoot == pytest.approx(other.overshoot, abs=1e-12)
    assert found.final_error == pytest.approx(-other.final_error, abs=1e-12)


def test_errors_are_those_of_the_carriage_not_of_its_sensor() -> None:
    """With 0.1 mm of noise the figures are of the true position, which the voltages give again."""
    rig = RigParameters({"sensors.position_noise": 1e-4})
    step = references.step(0.0, 0.058, at=0.1)
    run = closed_loop(rig, PidParameters(), step, 3.0, 1e-3)
    true = simulate(rig, run.voltage[:-1], 1e-3)
    assert np.array_equal(run.true_position, true.position)
    assert not np.array_equal(run.position, true.position)
    assert run_metrics(run).final_error == 0.058 - true.position[-1]


def test_each_figure_says_its_unit() -> None:
    """And none is without a name."""
    assert all(math.isfinite(value) for value in run_metrics(made(TIME * 0.0, TIME * 0.0))[:1])
    assert RunMetrics._fields[0] == "final_error"


@pytest.mark.parametrize("given", [5, None, "run1", simulate(RigParameters(), np.zeros(2), 1e-3)])
def test_what_is_no_closed_loop_is_refused(given: object) -> None:
    """A run without a reference has no error to measure; the line says what has."""
    with pytest.raises(TypeError, match=r"refused, must be a run of rodless_lab\.closed_loop$"):
        run_metrics(given)  # type: ignore[arg-type]
