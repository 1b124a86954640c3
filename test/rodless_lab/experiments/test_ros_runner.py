# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Experiments over ROS: the nodes' runs are those in process, to the last bit."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from extent import extensive
from quiet_stop import Quiet

from rodless_control import PidParameters, references
from rodless_lab.cli.experiment import main, parsed
from rodless_lab.experiments import fixed_chamber, ros_runner, step
from rodless_lab.experiments.catalogue import EXPERIMENTS
from rodless_lab.experiments.runner import IN_PROCESS, Runner
from rodless_lab.harness import NodeDiedError
from rodless_lab.simulation.closed_loop import ClosedLoopTrace
from rodless_sim import RigParameters, Trace
from rodless_sim.sensors import IDEAL

pytestmark = pytest.mark.ros

UNPUBLISHED = {"mass_flow_a", "mass_flow_b"}


@pytest.fixture
def runs() -> list[None]:
    """One entry for each run that the nodes have done."""
    return []


@pytest.fixture
def runner(runs: list[None]) -> Iterator[Runner]:
    """Return the runner of the nodes; at least one run must have been theirs."""
    yield ros_runner.nodes_runner(lambda: runs.append(None))
    assert runs


def assert_same(first: Trace, second: Trace) -> None:
    """Compare what ``first``, the run of the nodes, has: it has no terms of the law."""
    assert type(first) is type(second)
    for name, values in first.columns().items():
        if name not in UNPUBLISHED:
            assert np.array_equal(values, getattr(second, name)), name


def test_step_over_ros_gives_the_numbers_of_the_step_in_process(
    runner: Runner, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The closed-loop step, shortened to 1.5 s: every sample and every number are the same."""
    monkeypatch.setattr(step, "DURATION", 1.5)
    found, expected = (step.run_step(["calibrated"], where) for where in (runner, IN_PROCESS))
    assert_same(found.runs["calibrated"], expected.runs["calibrated"])
    assert len(found.runs["calibrated"].time) == 1501
    assert found.comparisons == expected.comparisons


def test_fixed_chamber_over_ros_gives_the_numbers_of_that_in_process(
    runner: Runner, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The open-loop run at 0.4 MPa, shortened to 3 s: samples and numbers are the same."""
    for name in ("END_TIME", "SETTLING_TIME", "VENTING_TIME"):
        monkeypatch.setattr(fixed_chamber, name, 1.0)
    found, expected = (
        fixed_chamber.run_fixed_chamber(0.05, [0.4e6], where) for where in (runner, IN_PROCESS)
    )
    assert_same(found.runs[0].trace, expected.runs[0].trace)
    assert len(found.runs[0].trace.time) == 1501
    assert found.comparisons == expected.comparisons


def test_sine_over_ros_starts_where_it_is_told_to(runner: Runner) -> None:
    """A sine followed from 80 mm, neither the rig's nor the controller's default: the same."""
    rig = RigParameters.preset("paper")
    pid = PidParameters.preset("paper").with_values({"controller.kp": 700.0})
    reference = references.sine(0.08, 0.015, 0.4, at=0.1)
    found, expected = (
        where.closed_loop(rig, pid, reference, 0.4, 2e-3, 0.08) for where in (runner, IN_PROCESS)
    )
    assert_same(found, expected)


def test_voltages_beyond_the_valve_are_held_at_its_limits(runner: Runner) -> None:
    """Commands of -3 V and 12 V over ROS are 0 V and 10 V, as in process."""
    rig = RigParameters.preset("calibrated").with_values({**IDEAL, "supply.pressure": 6e5})
    voltages = np.repeat([-3.0, 12.0, 5.3], 40)
    found, expected = (where.open_loop(rig, voltages, 1e-3, 0.1) for where in (runner, IN_PROCESS))
    assert_same(found, expected)
    assert np.isnan(found.mass_flow_a).all()


def test_only_steps_and_sines_can_be_asked_of_the_controller() -> None:
    """Other references are refused by name instead of being run as something else."""
    with pytest.raises(TypeError, match="Ramp"):
        ros_runner.reference_parameters(references.ramp(0.0, 0.1, 0.05))


def test_the_nodes_of_a_runner_follow_no_scenario() -> None:
    """The run in process, which they repeat to the bit, follows none either."""
    rig = RigParameters({"time.scenario": "leak", "supply.pressure": 6e5})
    values = ros_runner.plant_values(rig, 1e-3)
    assert "time.scenario" not in values
    assert values["supply.pressure"] == 6e5


@pytest.mark.parametrize("name", ["valve-area", "flow-coefficient", "errata"])
def test_experiments_without_a_moving_rig_refuse_ros(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Exit code 2, the reason and the experiments that can; no report."""
    out = tmp_path / "out"
    assert main([name, "--ros", "--output", str(out)], Quiet()) == 2
    said = capsys.readouterr().err
    assert f"{name} has no moving rig to drive" in said
    assert "friction, fixed-chamber, step, sine" in said
    assert not out.exists()


@extensive
def test_the_command_hands_the_bench_of_the_nodes_to_the_experiment(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """`rodless experiment step --ros` runs on that runner, with a dot for its run; without, not."""

    def stand_in(ran: Callable[[], None]) -> Runner:
        def closed_loop(*arguments: Any) -> ClosedLoopTrace:
            ran()
            return IN_PROCESS.closed_loop(*arguments)

        return Runner(IN_PROCESS.open_loop, closed_loop)

    monkeypatch.setattr(ros_runner, "nodes_runner", stand_in)
    arguments = ["step", "--preset", "calibrated", "--output", str(tmp_path)]
    assert main([*arguments, "--ros"], Quiet()) == 0
    assert "step ... ." in capsys.readouterr().out
    assert main(arguments, Quiet()) == 0
    assert "step ... ." not in capsys.readouterr().out


def test_nodes_that_fail_end_the_command_with_1(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A plant that ends during an experiment: its reason, exit code 1, no report."""

    def fail(*_: Any) -> Trace:
        raise NodeDiedError("the plant has ended with exit code 1")

    monkeypatch.setattr(ros_runner, "nodes_runner", lambda _: Runner(fail, fail))
    out = tmp_path / "out"
    assert main(["fixed-chamber", "--ros", "--output", str(out)], Quiet()) == 1
    assert "the plant has ended with exit code 1" in capsys.readouterr().err
    assert not out.exists()


def test_without_ros_everything_is_in_process() -> None:
    """The option is off by default, and the four that drive a rig are those that can take it."""
    assert not parsed(["step"]).ros
    able = {name for name, one in EXPERIMENTS.items() if one.moves}
    assert able == {"friction", "fixed-chamber", "step", "sine"}
