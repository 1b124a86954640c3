# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Linear models against the equations' own derivatives, the rig, and two other libraries."""

import math
import re
import sys
from pathlib import Path

import control
import numpy as np
import pytest
from small_step import small_step

from rodless_lab import LinearModel, linearise
from rodless_sim import RigParameters, simulate
from rodless_sim.physics.equations import inflows, sliding_rates
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings

PAGE = Path(__file__).resolve().parents[3] / "docs" / "linear-model.md"

PRESETS = ("paper", "calibrated")
VOLTAGES = (5.3, 5.5, 6.0, 8.0, 4.6, 4.0, 2.0)
PERIOD = 1e-3


def linear(preset: str) -> RigParameters:
    """A preset with four states, without what no linear model has."""
    return RigParameters.preset(preset).with_values(
        {
            "chambers.thermodynamics": "adiabatic",
            "valve.hysteresis": 0.0,
            "valve.dynamics": "none",
        }
    )


def model(preset: str = "paper", voltage: float = 6.0, position: float = 0.1) -> LinearModel:
    return linearise(linear(preset), position, voltage)


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize("voltage", VOLTAGES)
def test_a_rig_that_starts_in_the_steady_motion_stays_in_it(preset: str, voltage: float) -> None:
    """Over 0.1 mm, its velocity and pressures change as little as the volumes do."""
    point = model(preset, voltage).point
    position, velocity, *pressures = point.motion
    plant = Plant.of(linear(preset))
    lands = openings(plant, voltage)
    direction = 1 if velocity > 0 else -1
    found = sliding_rates(plant, point.motion, inflows(plant, lands, point.motion), direction)
    assert abs(found.acceleration) < 1e-6
    assert abs(found.a.rate) < 1e-3
    assert abs(found.b.rate) < 1e-3
    # Nothing in the search for it integrates; the rig does.
    run = simulate(
        linear(preset),
        np.full(3000, voltage),
        PERIOD,
        position - 0.04 * direction,
        (pressures[0], pressures[1]),
    )
    late = run.velocity[np.argmin(np.abs(run.position - position))]
    if abs(velocity) > 0.01:  # slower ones need more time than this to forget their start
        assert late == pytest.approx(velocity, rel=0.02)


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize("voltage", VOLTAGES)
def test_a_is_what_the_equations_say_beside_themselves(preset: str, voltage: float) -> None:
    """The integrator's analytic derivatives, which linearise does not use."""
    found = model(preset, voltage)
    plant = Plant.of(linear(preset))
    lands = openings(plant, voltage)
    motion = found.point.motion
    direction = 1 if motion.velocity > 0 else -1
    first = sliding_rates(plant, motion, inflows(plant, lands, motion), direction)
    expected = [
        [0.0, 1.0, 0.0, 0.0],
        [first.by_position, first.by_velocity, first.by_pressure, -first.by_pressure],
        [first.a.by_position, first.a.by_velocity, first.a.by_pressure, 0.0],
        [first.b.by_position, first.b.by_velocity, 0.0, first.b.by_pressure],
    ]
    scale = np.abs(expected) + np.array([[1e-9], [1e-6], [1.0], [1.0]])
    assert np.abs((found.A - expected) / scale).max() < 1e-5


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize("voltage", [5.5, 4.6])
@pytest.mark.parametrize("dynamics", ["none", "second_order"])
def test_the_rig_answers_a_small_step_as_the_model_does(
    preset: str, voltage: float, dynamics: str
) -> None:
    """5 mV for 50 ms, in steady motion: the difference to a run without, within 2 %."""
    parameters = linear(preset).with_values({"valve.dynamics": dynamics})
    found = linearise(parameters, 0.1, voltage)
    names = ["position", "velocity", "pressure_a", "pressure_b"]
    assert [state.name for state in found.states[:4]] == names
    assert (len(found.states) == 6) == (dynamics == "second_order")
    _, answers = small_step(parameters, found, 0.1)
    assert len(answers) == min(len(found.states), 5)
    for answer, expected in answers:
        assert np.abs(answer - expected).max() < 0.02 * np.abs(expected).max()


def test_the_spool_adds_its_poles() -> None:
    """−ζω ± jω√(1−ζ²) beside those of the rig without; hysteresis and dead time are refused."""
    spool = RigParameters({"valve.dynamics": "second_order"})
    omega = 2.0 * np.pi * 115.0
    plain, found = (linearise(rig, 0.1, 6.0).poles for rig in (RigParameters(), spool))
    pair = omega * np.array([-0.7 - 1j * np.sqrt(0.51), -0.7 + 1j * np.sqrt(0.51)])
    expected = np.sort_complex(np.concatenate([plain, pair]))
    assert np.abs(np.sort_complex(found) - expected).max() < 1e-6 * omega
    for name in ("valve.hysteresis", "valve.dead_time"):
        with pytest.raises(ValueError, match=f"{name}: 0.001 refused"):
            linearise(spool.with_values({name: 1e-3}), 0.1, 6.0)


def test_the_inputs_are_voltage_load_and_supply() -> None:
    """B by hand: a newton accelerates by 1/m; the other columns as other rigs have other rates."""
    parameters = RigParameters()
    found = linearise(parameters, 0.1, 6.0)
    names = [one.name for one in found.inputs]
    assert names == ["voltage", "load", "supply_pressure"]
    mass = parameters.number("cylinder.moving_mass")
    assert found.B[:, 1].tolist() == [0.0, 1.0 / mass, 0.0, 0.0]
    motion = found.point.motion

    def rates(voltage: float, supply: float) -> list[float]:
        plant = Plant.of(parameters.with_values({"supply.pressure": supply}))
        flows = inflows(plant, openings(plant, voltage), motion)
        first = sliding_rates(plant, motion, flows, 1)
        return [0.0, 0.0, first.a.rate, first.b.rate]

    supply = parameters.number("supply.pressure")
    by_voltage = np.subtract(rates(6.001, supply), rates(5.999, supply)) / 2e-3
    by_supply = np.subtract(rates(6.0, supply + 50.0), rates(6.0, supply - 50.0)) / 1e2
    assert found.B[:, 0] == pytest.approx(by_voltage, rel=1e-4)
    assert found.B[:, 2] == pytest.approx(by_supply, rel=1e-4)


def test_at_a_given_velocity_a_load_keeps_the_balance() -> None:
    """Force of the air, friction by Table 2 and the load add up to nothing."""
    parameters = RigParameters()
    area = np.pi / 4.0 * 0.025**2
    for velocity, friction in ((0.0, 29.0), (0.02, 12.0 + 90.0), (-0.03, -12.5 - 144.0)):
        point = linearise(parameters, 0.1, 5.2, velocity).point
        push = area * (point.motion.pressure_a - point.motion.pressure_b)
        assert point.motion.velocity == velocity
        assert push - friction + point.load == pytest.approx(0.0, abs=1e-6)
    assert linearise(parameters, 0.1, 6.0).point.load == 0.0


@pytest.mark.parametrize("preset", PRESETS)
def test_python_control_and_scipy_find_the_same(preset: str) -> None:
    """Poles, frequency response and names of the model in the two other libraries' classes."""
    found = model(preset)
    frequencies = np.geomspace(0.1, 100.0, 9)
    theirs = found.to_control()
    assert isinstance(theirs, control.StateSpace)
    assert theirs.output_labels == ["position", "velocity", "pressure_a", "pressure_b"]
    assert theirs.input_labels == ["voltage", "load", "supply_pressure"]
    channel = theirs["velocity", "voltage"]
    expected = [channel(2j * np.pi * frequency) for frequency in frequencies]
    assert found.response(frequencies, "velocity") == pytest.approx(expected, rel=1e-6)
    poles = np.sort_complex(theirs.poles())
    assert np.sort_complex(found.poles) == pytest.approx(poles, rel=1e-6, abs=1e-6)
    _, gains = found.to_scipy("velocity").freqresp(2.0 * np.pi * frequencies)
    assert gains == pytest.approx(expected, rel=1e-6)
    assert abs(found.poles[0]) < 1e-6  # wherever the carriage is
    assert (found.poles[1:].real < 0.0).all()


def test_sampled_response_is_the_continuous_one_behind_a_hold() -> None:
    """A hold of T delays by T/2: phase −π f T, gain sin(π f T)/(π f T), for f far below 1/T."""
    found = model("calibrated")
    frequencies = np.array([1.0, 3.0, 10.0])
    angle = np.pi * frequencies * 1e-3
    hold = np.sin(angle) / angle * np.exp(-1j * angle)
    sampled = found.sampled_response(frequencies, 1e-3)
    assert sampled == pytest.approx(found.response(frequencies) * hold, rel=1e-3)


def test_refusals_name_value_cause_and_way_out() -> None:
    """A carriage that sticks or is held, positions and voltages out of range, unknown names."""
    parameters = RigParameters()
    with pytest.raises(ValueError, match=r"at 5\.1 V the carriage sticks .* take a voltage"):
        linearise(parameters, 0.1, 5.1)
    for position in (0.0, 0.2, -1.0, float("nan")):
        with pytest.raises(ValueError, match="within the stroke"):
            linearise(parameters, position, 6.0)
    with pytest.raises(ValueError, match="saturates"):
        linearise(parameters, 0.1, 11.0)
    with pytest.raises(ValueError, match="finite"):
        linearise(parameters, 0.1, 6.0, velocity=float("inf"))
    with pytest.raises(ValueError, match=r"cylinder\.locked"):
        linearise(parameters.with_values({"cylinder.locked": True}), 0.1, 6.0)
    with pytest.raises(ValueError, match="energy_balance refused"):
        linearise(parameters.with_values({"chambers.thermodynamics": "energy_balance"}), 0.1, 6.0)
    with pytest.raises(TypeError, match="RigParameters"):
        linearise({}, 0.1, 6.0)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="'speed' is unknown: must be one of position, velocity"):
        model().response([1.0], "speed")
    with pytest.raises(ValueError, match="above 0"):
        model().response([0.0])
    with pytest.raises(ValueError, match=r"period 0\.0 s refused"):
        model().sampled_response([1.0], 0.0)
    for period in (3601.0, 1e300, math.inf):
        with pytest.raises(ValueError, match=r"^period .* s refused: must be above 0, and 3600 s"):
            model().sampled_response([1.0], period)
    for period in np.linspace(1e-3, 1e-2, 50):  # half of what is sampled itself, however rounded
        up_to_it = np.logspace(-1.0, np.log10(0.5 / period), 50)
        assert model().sampled_response(up_to_it, float(period)).size == 50
    with pytest.raises(ValueError, match=r"^frequencies refused: 1000\.0 Hz, .* up to 500 Hz"):
        model().sampled_response([1.0, 1000.0], 1e-3)
    with pytest.raises(ValueError, match=r"^frequencies refused: frequency b'1' refused"):
        model().response(b"1")
    assert model().response(np.array(3.0)) == model().response(3.0)


def test_python_control_that_is_missing_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """The error says how to get it."""
    monkeypatch.setitem(sys.modules, "control", None)
    with pytest.raises(ModuleNotFoundError, match=r"pip install 'rodless_sim\[control\]'"):
        model().to_control()


def test_what_the_page_shows_runs(capsys: pytest.CaptureFixture[str]) -> None:
    """The example of docs/linear-model.md prints what its comments say."""
    (example,) = re.findall(r"```python\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
    exec(compile(example, str(PAGE), "exec"), {})
    printed = capsys.readouterr().out
    assert "LinearModel at 100.000 mm" in printed
    assert "('pressure_b', 'Pa')" in printed
    assert "('load', 'N')" in printed
