# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Scenarios: what is read, what is refused, and when it happens."""

import pickle
from pathlib import Path

import numpy as np
import pytest

from rodless_base.parameter_file import preset_directory
from rodless_base.parameters import ParameterError
from rodless_sim import Rig, RigParameters, Scenario, ScenarioError, simulate
from rodless_sim.node.engine import Engine
from rodless_sim.scenario import MOST_ENTRIES, scenario_file, shipped_scenario

PERIOD = 1e-3
SHIPPED = sorted((preset_directory() / "scenarios").glob("*.yaml"))


def written(folder: Path, text: str) -> Path:
    """A file with this text."""
    path = folder / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_file_is_a_list_of_times_and_values(tmp_path: Path) -> None:
    """Names are dotted or nested, numbers as ROS writes them."""
    path = written(
        tmp_path,
        """
- at: 1
  fault.tube_a.burst: 1e-5
- at: 2.5
  fault: {tube_a.burst: 0, valve: {spool: stuck}}
  supply.pressure: 5.0e+5
""",
    )
    found = Scenario.from_file(path).entries
    assert [entry.stamp for entry in found] == [1_000_000_000, 2_500_000_000]
    assert found[0].changes == {"fault.tube_a.burst": 1e-5}
    assert found[1].changes == {
        "fault.tube_a.burst": 0.0,
        "fault.valve.spool": "stuck",
        "supply.pressure": 5e5,
    }
    assert found[0].text == "1 s: fault.tube_a.burst 1e-05 m²"


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("fault.valve.offset: 1", "not a scenario: must be a list"),
        ("", "not a scenario: must be a list"),
        ("- 5", "entry 1: 5 refused: must be a time in s, and parameters by name"),
        (
            "- {fault.valve.offset: 1}",
            "entry 1: `at:`, a time in s, is missing; it has 'fault.valve.offset'",
        ),
        ("- {At: 1, rail.tilt: 1}", "`at:`, a time in s, is missing; it has 'At', 'rail.tilt'"),
        ("- {}", "entry 1: `at:`, a time in s, is missing"),
        ("- {at: -1, fault.valve.offset: 1}", "entry 1: at -1 refused: must be from 0 to 1e+06 s"),
        ("- {at: .nan, fault.valve.offset: 1}", "entry 1: at nan refused"),
        ("- {at: yes, fault.valve.offset: 1}", "entry 1: at True refused"),
        ("- {at: 1}", "entry 1: {} refused: give parameters by name"),
        ("- {at: 1, fault.valve.ofset: 1}", "did you mean fault.valve.offset?"),
        ("- {at: 1, fault.valve.offset: 11}", "must be from -10 to 10 (V)"),
        ("- {at: 1, fault.valve.offset: 1, falt.tube_a.burst: {}}", "falt.tube_a.burst: holds not"),
        ("- {at: 1, 7: 11}", "entry 1: 7: no such parameter"),
        ("- {at: 1, fault.valve.spool: loose}", "must be one of free, stuck, stuck_at"),
        ("- {at: 1, time.period: 0.01}", "time.period: cannot change while the plant runs"),
        ("- {at: 1, fault: {valve.offset: 1, valve: {offset: 2}}}", "stands twice"),
        (
            "- {at: 2, fault.valve.offset: 1}\n- {at: 1, fault.valve.offset: 0}",
            "entry 2: at 1 s refused: the entry before it is at 2 s; put them in order of time",
        ),
        ("- {at: 1, at: 2}", "'at' stands twice"),
        ("- &a {at: 1}\n- *a", "aliases (*name) are not for ROS"),
        ("[" * 30, "nested more than 20 levels deep"),
        (
            "- {at: 1, fault.valve.offset: 1}\n" * (MOST_ENTRIES + 1),
            "more than 1000 entries refused",
        ),
        ("# " + "x" * 1_000_000, "not a scenario: larger than 1000 kB"),
    ],
)
def test_what_is_no_scenario_is_refused_in_one_line(tmp_path: Path, text: str, what: str) -> None:
    """The line begins with the file, and names entry, value and cause."""
    path = written(tmp_path, text)
    with pytest.raises(ScenarioError) as refused:
        Scenario.from_file(path)
    line = str(refused.value)
    assert line.startswith(f"{path}: ")
    assert what in line
    assert "\n" not in line


def test_a_file_that_is_not_there_is_said(tmp_path: Path) -> None:
    """As an OSError too; a name that no scenario of the package has lists those there are."""
    with pytest.raises(OSError, match=r"none\.yaml: cannot be read: No such file"):
        Scenario.from_file(tmp_path / "none.yaml")
    with pytest.raises(ScenarioError, match="there are leak, stuck_valve, supply_loss"):
        scenario_file("none")
    with pytest.raises(ScenarioError, match="no file and no scenario of the package: ''"):
        scenario_file("")


def test_an_array_that_is_one_number_is_no_list_of_entries() -> None:
    """Though numpy says that it can be iterated over."""
    with pytest.raises(ScenarioError, match=r"array\(0\.1\) refused: must be a list of entries"):
        Scenario(np.array(0.1))


def test_what_a_rig_would_refuse_later_is_refused_at_its_start() -> None:
    """An entry is checked with what those before it leave."""
    entries = [(1.0, {"atmosphere.pressure": 1.1e5}), (2.0, {"supply.pressure": 1.05e5})]
    rig = RigParameters({"supply.pressure": 1.2e5})
    with pytest.raises(ScenarioError, match=r"mine: entry 2: supply\.pressure: 105000 Pa refused"):
        Rig(rig, Scenario(entries, "mine"))
    Rig(rig, Scenario(entries[:1]))


def test_an_entry_takes_effect_at_the_first_sample_at_or_after_its_time() -> None:
    """Until then the run is that of a rig without; the sample of that time is read with it."""
    sound = simulate(RigParameters(), [9.0] * 200, PERIOD)
    for at in (0.1, 0.0995):
        rig = Rig(RigParameters(), Scenario([(at, {"fault.supply.loss": 1.0})]))
        for k in range(1, 200):
            state = rig.advance(9.0, PERIOD)
            assert (rig.read().supply_pressure == 101325.0) == (k >= 100)
            assert (state.pressure_a == sound.pressure_a[k]) == (k <= 100)
            assert len(rig.played) == (k >= 100)


def test_a_scenario_is_the_same_as_changes_by_hand() -> None:
    """A rig that is configured at the same samples goes through the same states."""
    changes = {0.05: {"fault.tube_b.burst": 1e-6}, 0.1: {"supply.pressure": 5e5}}
    rig = Rig(RigParameters())
    expected = [rig.state.pressure_b]
    for k in range(1, 201):
        expected.append(rig.advance(7.0, PERIOD).pressure_b)
        if k * PERIOD in changes:
            rig.configure(rig.parameters.with_values(changes[k * PERIOD]))
    run = simulate(RigParameters(), [7.0] * 200, PERIOD, scenario=Scenario(changes.items()))
    assert np.array_equal(run.pressure_b, expected)
    assert not np.array_equal(
        run.pressure_b, simulate(RigParameters(), [7.0] * 200, PERIOD).pressure_b
    )


def test_step_by_step_and_compiled_runs_are_equal() -> None:
    """With a scenario that is never due, every column is that of the run without, bit for bit."""
    never = Scenario([(100.0, {"fault.valve.offset": 1.0})])
    for preset in ("paper", "calibrated"):
        parameters = RigParameters.preset(preset)
        voltages = 5.0 + 2.0 * np.sin(np.arange(500) * 0.02)
        runs = [simulate(parameters, voltages, PERIOD, 0.1, scenario=s) for s in (None, never)]
        for name, column in runs[0].columns().items():
            assert np.array_equal(column, runs[1].columns()[name]), name


def test_a_reset_starts_it_anew() -> None:
    """With what it had changed as it was before, and what is due at 0 from sample 0 on."""
    entries = [(0.0, {"fault.valve.offset": 0.3}), (0.1, {"fault.carriage.seized": True})]
    rig = Rig(RigParameters({"fault.valve.offset": 0.1}), Scenario(entries))
    assert len(rig.played) == 1

    def run() -> list[float]:
        return [rig.advance(7.0, 0.02).position for _ in range(10)]

    first = run()
    assert first[5] == first[-1] > first[3]
    assert rig.parameters["fault.carriage.seized"] is True
    rig.configure(rig.parameters.with_values({"fault.valve.offset": 0.0, "leak.a": 1e-9}))
    rig.reset()
    assert rig.parameters["fault.carriage.seized"] is False
    assert (rig.parameters["fault.valve.offset"], rig.parameters["leak.a"]) == (0.3, 1e-9)
    rig.configure(rig.parameters.with_values({"leak.a": 0.0}))
    rig.reset()
    assert run() == first


def test_a_rig_with_a_scenario_can_be_copied() -> None:
    """A pickled one goes on where it was."""
    rig = Rig(RigParameters(), Scenario([(0.1, {"fault.valve.offset": 1.0})]))
    rig.advance(6.0, 0.05)
    copy = pickle.loads(pickle.dumps(rig))
    assert copy.advance(6.0, 0.05) == rig.advance(6.0, 0.05)
    assert copy.played == rig.played != ()


SHORTER = Scenario([(0.5, {"cylinder.stroke": 0.01})], "shorter")


def test_an_entry_that_the_state_does_not_allow_stops_the_run() -> None:
    """A stroke that ends before the carriage: an error in Python, a closed valve in the node."""
    with pytest.raises(ScenarioError, match=r"shorter: entry 1: cylinder\.stroke: 0\.01 m refused"):
        simulate(RigParameters(), [9.0] * 1000, PERIOD, scenario=SHORTER)
    samples: list[int] = []
    engine = Engine(RigParameters(), lambda seen, _: samples.append(seen.stamp), SHORTER)
    for _ in range(600):
        engine.receive(9.0)
        engine.step()
    assert len(samples) == 499
    assert str(engine.failure).startswith("shorter: entry 1: cylinder.stroke")
    engine.reset()
    assert engine.failure is None


@pytest.mark.parametrize(
    ("entry", "live", "reason"),
    [
        (
            {"friction.forward.static": 50.0},
            {"friction.forward.coulomb": 40.0},
            r"friction\.forward\.static: 29 N refused, below friction\.forward\.coulomb \(40 N\)",
        ),
        (
            {"cylinder.initial_position": 0.01},
            {"cylinder.stroke": 0.05},
            r"cylinder\.initial_position: 0\.1 m refused",
        ),
    ],
)
def test_no_change_takes_the_way_back_to_the_start_away(
    entry: dict[str, object], live: dict[str, object], reason: str
) -> None:
    """What fits what the scenario has made, but not what a reset returns to, is refused."""
    rig = Rig(RigParameters({"cylinder.initial_position": 0.1}), Scenario([(0.01, entry)]))
    rig.reset(0.02)
    for _ in range(20):
        rig.advance(5.08, PERIOD)
    state, parameters = rig.state, rig.parameters
    with pytest.raises(ParameterError, match=f"^refused, as a reset takes .* then: {reason}"):
        rig.configure(parameters.with_values(live))
    assert (rig.state, rig.parameters) == (state, parameters)
    rig.reset()


@pytest.mark.parametrize(
    ("base", "entry"),
    [
        ({"cylinder.moving_mass": 2.0}, {"cylinder.model": "CY3R25-300"}),
        ({"friction.forward.static": 35.0}, {"cylinder.model": "CY3R25-300"}),
        ({"cylinder.model": "other", "cylinder.stroke": 0.3}, {"cylinder.model": "CY3R25-200"}),
        ({"air.critical_ratio": 0.5285}, {"air.isentropic_index": 1.3}),
        ({"cylinder.moving_mass": 2.0}, {"cylinder.stroke": 0.15}),
    ],
)
def test_a_reset_takes_back_what_followed_from_an_entry(
    base: dict[str, object], entry: dict[str, object]
) -> None:
    """A model brings a mass and more of its own: the second run is the first to the last bit."""
    rig = Rig(RigParameters(base), Scenario([(0.01, entry)]))
    first = [rig.advance(6.5, PERIOD) for _ in range(20)]
    assert rig.parameters != RigParameters(base)
    rig.reset()
    assert rig.parameters == RigParameters(base)
    assert [rig.advance(6.5, PERIOD) for _ in range(20)] == first


def test_a_reset_takes_back_what_the_scenario_has_changed_and_nothing_else() -> None:
    """A stroke has its model come back, which has a mass and friction: the rig has its own."""
    own = {"cylinder.moving_mass": 2.0, "friction.forward.static": 20.0}
    rig = Rig(RigParameters(own), Scenario([(0.0, {"cylinder.stroke": 0.15})]))
    expected = RigParameters({**own, "cylinder.stroke": 0.15})
    for live in ({}, {"friction.reverse.static": 50.0}):
        rig.configure(rig.parameters.with_values(live))
        for _ in range(2):
            rig.reset()
            assert rig.parameters.differences(expected.with_values(live)) == {}


@pytest.mark.parametrize("live", [{"cylinder.bore": 0.02}, {"cylinder.model": "CY3R15-200"}])
def test_a_reset_takes_back_a_cylinder_that_its_model_contradicts(live: dict[str, object]) -> None:
    """With the model comes what it has, and what it was given; a change of the user's is taken."""
    own = RigParameters({"cylinder.moving_mass": 2.0, "friction.forward.static": 20.0})
    rig = Rig(own, Scenario([(0.01, {"cylinder.stroke": 0.15})]))
    rig.configure(rig.parameters.with_values(live))
    rig.reset()
    assert rig.parameters.differences(own) == {}


def test_a_name_that_is_no_text_is_shown_in_a_short_line() -> None:
    """Python refuses to write a number of thousands of digits."""
    with pytest.raises(ScenarioError, match=r"^<list that cannot be shown>: entry 1") as refusal:
        Scenario([(-1.0, {"fault.piston.leak": 0.0})], [1, 10**5000])  # type: ignore[arg-type]
    assert len(str(refusal.value)) < 300
    assert Scenario([], "mine").name == "mine"


def test_the_engine_tells_whoever_must_know_before_the_sample() -> None:
    """Parameters that have changed are told with their time, and then their sample comes."""
    told: list[tuple[str, object]] = []
    engine = Engine(
        RigParameters(),
        lambda seen, _: told.append(("sample", seen.stamp)),
        Scenario([(0.002, {"valve.closed_voltage": 5.2})]),
        lambda values, time: told.append((str(values["valve.closed_voltage"]), time)),
    )
    for _ in range(2):
        engine.step()
    assert told == [("5.08", 0), ("sample", 10**6), ("5.2", 2 * 10**6), ("sample", 2 * 10**6)]
    engine.reset()
    assert told[4:] == [("5.08", 0), ("sample", 0)]


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_those_of_the_package_run_and_end_without_a_fault(path: Path) -> None:
    """Each is found by name, fits both presets, and leaves the rig as it was."""
    assert shipped_scenario(path.stem) == path
    for preset in ("paper", "calibrated"):
        parameters = RigParameters.preset(preset)
        scenario = Scenario.from_file(path)
        rig = Rig(parameters, scenario)
        for _ in range(40):
            rig.advance(6.0, 0.1)
        assert len(rig.played) == len(scenario.entries) > 1
        assert rig.parameters == parameters
