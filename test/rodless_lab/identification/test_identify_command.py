# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""From a bag to a parameter file that the plant loads."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import yaml
from extent import extensive, some_of
from no_room import fill_up
from quiet_stop import Quiet

from rodless_lab.cli import identify
from rodless_lab.identification.coverage import KNOWN, SUBJECTS, measured_run
from rodless_lab.identification.parameter_writer import Finding, parameter_text
from rodless_sim import ParameterError, RigParameters

pytestmark = pytest.mark.slow


def intervals(text: str) -> dict[str, tuple[float, float]]:
    """Read what the comments say of each parameter: (low, high)."""
    found = {}
    lines = text.splitlines()
    for comment, line in pairwise(lines):
        if ": 95 % from " in comment and not line.strip().startswith("#"):
            low, _, rest = comment.split(": 95 % from ")[1].partition(" to ")
            found[line.strip().partition(":")[0]] = (float(low), float(rest.split()[0].strip(";")))
    return found


@pytest.mark.parametrize("subject", some_of(list(SUBJECTS), 2))
def test_hidden_rig_is_found_through_a_bag(tmp_path: Path, write_bag, subject: str) -> None:
    """A rig with hidden parameters, measured and recorded: the file's intervals cover them.

    The seed is one that any sound identification covers: the round trip over many draws says in
    how many it may miss.
    """
    kind = SUBJECTS[subject]
    generator = np.random.default_rng(3)
    hidden, truth = kind.hide(generator)
    run = measured_run(hidden, kind.voltages, generator)
    bag, output = write_bag(tmp_path / "bag", run), tmp_path / "found.yaml"
    base = tmp_path / "base.yaml"
    known = [Finding(name, float(hidden.number(name)), {}) for name in kind.known]
    base.write_text(parameter_text([], known), encoding="utf-8")

    arguments = [subject, str(bag), "-o", str(output), "--base", str(base)]
    assert identify.main(arguments, Quiet()) == 0

    found = RigParameters.from_file(output)
    said = intervals(output.read_text(encoding="utf-8"))
    compared = 0
    for name, (low, high) in said.items():
        if name in truth:
            assert low <= truth[name] <= high, name
            assert low <= found.number(name) <= high, name
            compared += 1
    assert compared >= min(3, len(truth) - 1)
    # What was found acts in a plant that loads the file.
    for name in ("chambers.thermodynamics", "friction.dynamics"):
        assert found.text(name) == hidden.text(name)


def test_area_curve_is_scaled_as_a_whole(tmp_path: Path, write_bag) -> None:
    """`valve` writes nine coefficients: amplitudes scaled by one factor, the rest untouched."""
    generator = np.random.default_rng(5)
    hidden, truth = SUBJECTS["valve"].hide(generator)
    bag = write_bag(tmp_path / "bag", measured_run(hidden, SUBJECTS["valve"].voltages, generator))
    output = tmp_path / "found.yaml"
    assert identify.main(["valve", str(bag), "-o", str(output)], Quiet()) == 0
    ratio = np.divide(
        RigParameters.from_file(output).numbers("valve.area_coefficients"),
        KNOWN.numbers("valve.area_coefficients"),
    )
    assert ratio[[1, 2, 4, 5, 7, 8]] == pytest.approx(1.0, rel=1e-8)
    assert ratio[[0, 3, 6]] == pytest.approx(truth["area factor"], rel=0.01)


def test_a_full_disk_leaves_neither_parameters_nor_picture(
    tmp_path: Path, write_bag, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """With room for one file of the two there is neither; the line names a file, the code is 2."""
    generator = np.random.default_rng(5)
    hidden, _ = SUBJECTS["valve"].hide(generator)
    bag = write_bag(tmp_path / "bag", measured_run(hidden, SUBJECTS["valve"].voltages, generator))
    output = tmp_path / "found.yaml"
    fill_up(monkeypatch, room=1)
    assert identify.main(["valve", str(bag), "-o", str(output)], Quiet()) == 2
    said = capsys.readouterr()
    assert said.err.splitlines()[-1].endswith(": cannot be written: No space left on device")
    assert "written to" not in said.out
    assert [path.name for path in tmp_path.iterdir()] == ["bag"]


def test_the_file_is_one_ros_accepts() -> None:
    """One node section with ros__parameters; every number is a YAML real, not an integer or text.

    ROS refuses an integer for a real, and YAML 1.1 takes 1e-05 for a text.
    """
    values = {
        "cylinder.dead_volume_a": 2e-5,
        "friction.forward.static": 30.0,
        "friction.forward.viscous": 4e3,
        "supply.pressure": 6e5,
    }
    findings = [Finding(name, value, {}) for name, value in values.items()]
    document = yaml.safe_load(parameter_text(["about"], findings))
    read = document["/**/plant"]["ros__parameters"]
    assert read == values
    assert all(type(value) is float for value in read.values())


def test_values_no_plant_takes_are_not_written() -> None:
    """A fit may leave a parameter's range; the file would be refused, so it is not made."""
    with pytest.raises(ParameterError, match=r"friction\.forward\.viscous"):
        parameter_text([], [Finding("friction.forward.viscous", 2e5, {})])


@extensive
def test_ideal_sensors_narrow_the_interval(tmp_path: Path, write_bag) -> None:
    """Told that its sensors have no bias, the same bag gives F_c to a fraction of the width."""
    kind = SUBJECTS["friction"]
    generator = np.random.default_rng(4)
    hidden, _ = kind.hide(generator)
    bag = write_bag(tmp_path / "bag", measured_run(hidden, kind.voltages, generator))
    output = tmp_path / "found.yaml"
    widths = []
    for sensors in ("data-sheet", "ideal"):
        arguments = ["friction", str(bag), "-o", str(output), "--sensors", sensors]
        assert identify.main(arguments, Quiet()) == 0
        low, high = intervals(output.read_text(encoding="utf-8"))["friction.forward.coulomb"]
        widths.append(high - low)
    assert widths[1] < 0.2 * widths[0]
