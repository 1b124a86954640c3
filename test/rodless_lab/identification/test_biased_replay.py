# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Identified friction holds the bias of the sensors it was identified with; a replay shows it."""

import json
from pathlib import Path

import numpy as np
import pytest
from extent import extensive
from quiet_stop import Quiet

from rodless_lab.cli import replay as command
from rodless_lab.identification import identify_friction
from rodless_lab.identification.excitation import friction_voltages, steps
from rodless_lab.identification.friction.findings import friction_findings
from rodless_lab.identification.friction.run import bias_force
from rodless_lab.identification.parameter_writer import parameter_text, title
from rodless_lab.runs.comparison import difference
from rodless_lab.runs.from_bag import read_run
from rodless_lab.runs.measured_run import MeasuredRun, run_of_trace
from rodless_lab.runs.resimulate import replay
from rodless_sim import RigParameters, simulate
from rodless_sim.instruments.instruments import DATA_SHEET, PRESSURE_RANGE
from rodless_sim.physics.cylinder import piston_area

pytestmark = pytest.mark.slow

RIG = RigParameters.preset("paper")
SHEET = RigParameters(DATA_SHEET)

# Pa: what the data sheet allows.
BIAS = SHEET.number("sensors.pressure_bias") * PRESSURE_RANGE


def biased(voltages: np.ndarray, bias_a: float, bias_b: float, position: float) -> MeasuredRun:
    """A run of the rig as sensors with these biases (Pa), and no other error, read it."""
    run = simulate(RIG, voltages, 1e-3, position=position)
    seen = run_of_trace(run, RIG.number("supply.pressure"))
    columns = seen.columns()
    columns["pressure_a"] = seen.pressure_a + bias_a
    columns["pressure_b"] = seen.pressure_b + bias_b
    return MeasuredRun(**columns)


def identified(run: MeasuredRun) -> str:
    """The parameter file that an identification of ``run`` writes."""
    findings = friction_findings(identify_friction(run, SHEET), SHEET)
    return parameter_text(title("friction", "run1", run, "data-sheet", "paper"), findings)


def farthest(parameters: RigParameters, run: MeasuredRun) -> float:
    """How far in m a replay leaves the recorded position at most."""
    again = replay(parameters, run)
    return difference(run.time, run.position, again.position).largest


def test_a_bias_makes_identified_friction_worse_than_the_preset(tmp_path: Path) -> None:
    """Sensors 5 kPa high in A and low in B: F_c is off by 4.9 N, and a replay by 7 mm.

    Replayed is the very run that it was identified from. The preset has the rig's own friction, and
    misses the record by 1 mm, because it starts at the pressures as read. A file from sensors
    zeroed against each other misses it by less.
    """
    distances = {}
    for name, bias in (("biased", BIAS), ("zeroed", 0.0)):
        file = tmp_path / f"{name}.yaml"
        run = biased(friction_voltages(), bias, -bias, 0.06)
        file.write_text(identified(run))
        found = RigParameters.from_file(file)
        offset = found.number("friction.forward.coulomb") - RIG.number("friction.forward.coulomb")
        assert offset == pytest.approx(2.0 * bias * piston_area(RIG), abs=0.3)
        distances[name] = farthest(found, run), farthest(RIG, run)
    biased_file, preset = distances["biased"]
    assert biased_file > 5e-3
    assert preset < 1.5e-3
    assert distances["zeroed"][0] < 0.5e-3


def test_size_of_the_bias_by_hand() -> None:
    """±5 kPa on each side of 490.87 mm², of which 98 of 100 pairs reach 1.717: 4.2 N."""
    assert bias_force(SHEET) == pytest.approx(1.7172 * 5e3 * 490.874e-6, rel=1e-4)


@pytest.mark.parametrize(("subject", "warned"), [("friction", 1), ("valve", 0), (None, 0)])
def test_replay_says_that_friction_was_identified(
    tmp_path: Path,
    write_bag,
    capsys: pytest.CaptureFixture[str],
    subject: str | None,
    warned: int,
) -> None:
    """One line with the size of the bias and the page, for a file that `identify friction` wrote.

    Not for one by hand, nor for the valve and the chambers, whose fit takes the bias out.
    """
    run = biased(steps((5.4, 3.0)), 0.0, 0.0, 0.06)
    bag, file = write_bag(tmp_path / "bag", run), tmp_path / "mine.yaml"
    heading = title(subject, "run1", run, "data-sheet", "paper") if subject else ["by hand"]
    file.write_text(parameter_text(heading, []), encoding="utf-8")
    arguments = [str(bag), "--parameters", str(file), "--output", str(tmp_path / "out")]
    assert command.main(arguments, Quiet()) == 0
    said = [line for line in capsys.readouterr().out.splitlines() if "identified" in line]
    assert len(said) == warned
    for line in said:
        assert line.startswith("mine.yaml was identified: ")
        assert "±5 kPa each or 4.2 N" in line
        assert "docs/identification.md" in line


def test_replay_with_a_file_that_is_not_there(
    tmp_path: Path, write_bag, capsys: pytest.CaptureFixture[str]
) -> None:
    """The file is named, not the folder of the output: code 2, nothing written."""
    bag = write_bag(tmp_path / "bag", biased(steps((5.4, 0.1)), 0.0, 0.0, 0.06))
    arguments = [str(bag), "--parameters", str(tmp_path / "no.yaml")]
    assert command.main([*arguments, "--output", str(tmp_path / "out")], Quiet()) == 2
    assert f"{tmp_path / 'no.yaml'}: cannot be read" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_replay_takes_what_is_for_the_rig_of_the_bag(
    tmp_path: Path, write_bag, capsys: pytest.CaptureFixture[str]
) -> None:
    """A file for other rigs is refused by name, and their sections count for none but theirs."""
    bag, file = (
        write_bag(tmp_path / "bag", biased(steps((5.4, 0.1)), 0.0, 0.0, 0.06)),
        tmp_path / "two.yaml",
    )
    others = (
        "/left/plant: {ros__parameters: {cylinder.mas: 3.0}}\n/right/plant: {ros__parameters: {}}\n"
    )
    file.write_text(others)
    arguments = [str(bag), "--parameters", str(file), "--output", str(tmp_path / "out")]
    assert command.main(arguments, Quiet()) == 2
    assert capsys.readouterr().err == (
        f"{file}: no section is for the plant or controller of namespace /; "
        "it has /left/plant, /right/plant\n"
    )
    file.write_text(f"{others}plant: {{ros__parameters: {{cylinder.moving_mass: 3.0}}}}\n")
    assert command.main(arguments, Quiet()) == 0
    capsys.readouterr()
    assert command.main([*arguments, "--namespace", "/left"], Quiet()) == 2
    assert f"{file}: cylinder.mas: no such parameter" in capsys.readouterr().err


@extensive
def test_replay_lays_a_file_on_the_preset(
    tmp_path: Path, write_bag, capsys: pytest.CaptureFixture[str]
) -> None:
    """A file of one value: the others are those of --preset, by default those of paper.

    What a replay writes is compared with a simulation of the same parameters; a file with a name
    that no parameter has is named.
    """
    run = biased(steps((5.4, 3.0)), 0.0, 0.0, 0.06)
    bag, file = write_bag(tmp_path / "bag", run), tmp_path / "mine.yaml"
    file.write_text("/**/plant:\n  ros__parameters:\n    cylinder.moving_mass: 3.0\n")
    recorded = read_run(bag)
    largest = []
    for preset in ("paper", "calibrated"):
        out = tmp_path / preset
        arguments = ["--preset", preset, "--parameters", str(file), "--output", str(out)]
        assert command.main([str(bag), *arguments], Quiet()) == 0
        written = json.loads((out / "replay.json").read_text(encoding="utf-8"))
        layered = RigParameters.preset(preset).with_values({"cylinder.moving_mass": 3.0})
        largest.append(farthest(layered, recorded))
        assert written["position"]["largest"] == largest[-1]
    assert largest[0] != largest[1]
    file.write_text("/**/plant:\n  ros__parameters:\n    cylinder.mas: 3.0\n")
    assert command.main([str(bag), "--parameters", str(file), "--output", str(out)], Quiet()) == 2
    assert f"{file}: cylinder.mas: no such parameter" in capsys.readouterr().err
