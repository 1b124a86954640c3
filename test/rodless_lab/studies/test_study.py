# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Studies: what their rows are, and each way in which one cannot be done."""

import re
from pathlib import Path
from shutil import copy

import numpy as np
import pytest

from rodless_base.parameter_file import preset_directory
from rodless_lab.studies.errors import StudyError
from rodless_lab.studies.saved_study import read_saved_study, study_text
from rodless_lab.studies.shipped import shipped
from rodless_lab.studies.study import Study, read_study
from rodless_sim import RigParameters

GOOD = """
base: calibrated
vary:
  supply.pressure: {from: 5.0e5, to: 7.0e5, count: 3}
  friction.*.static: {from: 0.8, to: 1.2, count: 2, factor: true}
  friction.form: [stribeck, saturating]
"""


def written(folder: Path, text: str) -> Path:
    """A study file of this text."""
    path = folder / "study.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_grid_has_every_combination_once(tmp_path: Path) -> None:
    """The last axis changes fastest; a pattern of parameters changes them by one factor."""
    study = read_study(written(tmp_path, GOOD))
    assert len(study) == 12
    rows = [study.row(number) for number in range(12)]
    assert len({tuple(row.levels.values()) for row in rows}) == 12
    assert [row.base.rig["friction.form"] for row in rows[:2]] == ["stribeck", "saturating"]
    base = study.base.rig
    last = rows[-1].base.rig
    assert last["supply.pressure"] == 7e5
    for side in ("forward", "reverse"):
        name = f"friction.{side}.static"
        assert last.number(name) == base.number(name) * 1.2


def test_the_law_varies_within_a_study(tmp_path: Path) -> None:
    """Each row has its law as the base tunes it, and of `set` what is its own; saved and read."""
    text = """
set: {reference.target: 0.03, controller.kp: 500.0, adrc.filter_bandwidth: 300.0}
vary:
  controller.law: [pid, adrc]
  controller.neutral_voltage: [5.0, 5.1]
"""
    study = read_study(written(tmp_path, text))
    (tmp_path / "study.json").write_text(study_text(study), encoding="utf-8")
    for one in (study, read_saved_study(tmp_path)):
        found = [one.row(number).base.controller for number in range(len(one))]
        assert [row["controller.law"] for row in found] == ["pid", "pid", "adrc", "adrc"]
        assert [row["controller.neutral_voltage"] for row in found] == [5.0, 5.1, 5.0, 5.1]
        assert {row["reference.target"] for row in found} == {0.03}
        assert found[0]["controller.kp"] == 500.0
        assert found[2]["adrc.filter_bandwidth"] == 300.0


def test_a_logarithmic_axis_is_even_in_its_logarithm(tmp_path: Path) -> None:
    """Five values over four decades are decades apart."""
    text = "vary: {friction.capture_velocity: {from: 1.0e-8, to: 1.0e-4, count: 5, "
    study = read_study(written(tmp_path, text + "scale: logarithmic}}"))
    values = [float(str(study.row(k).levels["friction.capture_velocity"])) for k in range(5)]
    assert np.log10(values) == pytest.approx([-8.0, -7.0, -6.0, -5.0, -4.0])


def test_ideal_sensors_take_away_those_of_the_base(tmp_path: Path) -> None:
    """`calibrated` has noise, and a study may ask for the rig without it."""
    varied = "vary: {controller.ki: [10.0, 20.0]}"
    kept = read_study(written(tmp_path, f"base: calibrated\n{varied}")).row(0).base.rig
    ideal = read_study(written(tmp_path, f"sensors: ideal\n{varied}")).row(0).base.rig
    assert kept.number("sensors.position_noise") > 0.0
    changed = [name for name in ideal if ideal[name] != kept[name] and "seed" not in name]
    assert changed
    for name in changed:
        assert ideal[name] == RigParameters.DECLARATIONS[name].default, name


def test_sensors_law_and_reference_are_set_by_the_names_of_the_nodes(tmp_path: Path) -> None:
    """As in a parameter file, and of both nodes at once."""
    text = """
base: paper
sensors: data-sheet
set: {reference.type: sine, reference.amplitude: 0.01, controller.kp: 500.0}
vary: {controller.ki: [10.0, 20.0]}
run: {duration: 2.0, period: 0.002, since: 1.0}
"""
    row = read_study(written(tmp_path, text)).row(1)
    assert row.base.rig.number("sensors.position_noise") > 0.0
    assert row.base.controller["controller.kp"] == 500.0
    assert row.base.controller["controller.ki"] == 20.0
    assert type(row.base.reference).__name__ == "Sine"
    assert (row.base.duration, row.base.period, row.base.since) == (2.0, 0.002, 1.0)


def test_a_parameter_file_beside_the_study_is_its_base(tmp_path: Path) -> None:
    """Found from where the study is, and not from where the command runs."""
    (tmp_path / "mine.yaml").write_text(
        "/**/plant: {ros__parameters: {supply.pressure: 5.5e5}}\n", encoding="utf-8"
    )
    study = read_study(written(tmp_path, "base: mine.yaml\n"))
    assert study.row(0).base.rig["supply.pressure"] == 5.5e5


def test_a_parameter_file_brings_its_law(tmp_path: Path) -> None:
    """A base that names the cascade has it, with its gains; a law that is set wins."""
    copy(preset_directory() / "laws" / "cascade.yaml", tmp_path / "mine.yaml")
    study = read_study(written(tmp_path, "base: mine.yaml\n"))
    assert study.base.controller["controller.law"] == "cascade"
    assert study.base.controller["cascade.mass"] == 1.96


def test_a_saltelli_design_is_that_of_salib(tmp_path: Path) -> None:
    """N (D + 2) rows within the ranges; its rows are shares of the axes."""
    from SALib.sample import sobol  # noqa: PLC0415

    text = "vary: {supply.pressure: {from: 5.0e5, to: 7.0e5}, controller.ki: {from: 1.0, to: 9.0}}"
    study = read_study(written(tmp_path, text + "\ndesign: {method: saltelli, rows: 8, seed: 3}"))
    problem = {"num_vars": 2, "names": ["a", "b"], "bounds": [[5e5, 7e5], [1.0, 9.0]]}
    expected = sobol.sample(problem, 8, calc_second_order=False, seed=3)
    assert np.array(study.levels) == pytest.approx(expected)
    assert len(study) == 8 * 4
    # The rows of one base sample differ in an axis alone, and so have the same noise.
    seeds = [study.row(k).base.rig["sensors.seed"] for k in range(32)]
    assert [len(set(seeds[k : k + 4])) for k in range(0, 32, 4)] == [1] * 8
    assert len(set(seeds)) == 8


def test_a_study_is_read_back_from_beside_its_results(tmp_path: Path) -> None:
    """Rows and all, without its file."""
    study = read_study(written(tmp_path, GOOD))
    (tmp_path / "study.json").write_text(study_text(study), encoding="utf-8")
    (tmp_path / "study.yaml").unlink()
    again = read_saved_study(tmp_path)
    assert [again.row(k) for k in range(12)] == [study.row(k) for k in range(12)]
    assert study_text(again) == study_text(study)


@pytest.mark.parametrize("name", shipped("studies"))
def test_the_studies_that_ship_can_be_done(name: str) -> None:
    """By name, and all of their rows are rigs."""
    study = read_study(name)
    assert isinstance(study, Study)
    assert len(study) > 10


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            "vary: {supply.presure: [6.0e5]}",
            "vary: supply.presure: no such parameter; did you mean",
        ),
        ("vary: {supply.pressure: [-1.0]}", "vary: row 0 of 1: supply.pressure: -1.0 refused"),
        ("vary: {supply.pressure: {from: 6.0e5}}", "vary: supply.pressure: to: missing; give from"),
        (
            "vary: {supply.pressure: {from: 7.0e5, to: 6.0e5}}",
            "vary: supply.pressure: from 700000.0 to 600000.0 refused",
        ),
        (
            "vary: {supply.pressure: {from: 6.0e5, to: 7.0e5}}",
            "design: supply.pressure: from 600000 to 700000 refused: a grid needs its count",
        ),
        (
            "vary: {supply.pressure: 6.0e5}",
            "vary: supply.pressure: 600000.0 refused, must be names",
        ),
        ("vary: {supply.pressure: []}", "vary: supply.pressure: no values to choose from"),
        (
            "vary: {friction.*.static: [1.0], friction.forward.static: [30.0]}",
            "friction.forward.static is varied by friction.*.static too",
        ),
        ("vary: {reference.type: [sine]}", "vary: reference.type: cannot vary within a study"),
        ("vary: {controller.l*: [pid]}", "controller.law cannot vary with others"),
        ("vary: {controller.law: pid}", "vary: controller.law: must be a list of laws"),
        ("vary: {controller.law: [pd]}", "vary: controller.law: 'pd' refused: must be pid"),
        (
            "{set: {controller.law: pid}, vary: {controller.law: [pid]}}",
            "set: controller.law refused: it varies",
        ),
        (
            "vary: {controller.law: [pid, adrc], controller.kp: [100.0]}",
            "vary: controller.kp: adrc has no such parameter; vary it in another study",
        ),
        (
            "{set: {cascade.mass: 1.0}, vary: {controller.law: [pid, adrc]}}",
            "set: cascade.mass: belongs to the law cascade, which controller.law chooses",
        ),
        ("set: {friction.coulom: 1.0}", "set: friction.coulom: no such parameter; did you mean"),
        ("set: {cascade.mas: 1.0}", "no such parameter; did you mean cascade.mass of cascade?"),
        (
            "vary: {friction.form: {from: 1, to: 2, count: 2, factor: true}}",
            "row 0 of 2: friction.form: 'saturating' times 1.0 refused: no numbers",
        ),
        ("base: papr", "base: papr: neither a preset (calibrated, paper) nor a parameter file"),
        ("base: arm.yaml", "arm.yaml: no section is for the plant or controller; it has Plant"),
        ("base: two.yaml", "two.yaml: /left/plant and /right/plant are for different rigs; keep"),
        ("base: each.yaml", "each.yaml: /left/plant and /right/controller are for different rigs"),
        ("set: {supply.pressure: -1.0}", "set: supply.pressure: -1.0 refused"),
        ("set: {sensors.seed: 3}", "set: sensors.seed refused: each row has a seed of its own"),
        ("vary: {sensors.seed: [1, 2]}", "vary: sensors.seed: sensors.seed refused: each row has"),
        (
            "set: {reference.type: move}",
            "set: reference.type: move refused, it waits for set-points",
        ),
        ("set: {controller.law: pd}", "set: controller.law: 'pd' refused: must be pid"),
        ("design: {method: gird}", "design: method: 'gird' refused, must be grid, random"),
        ("design: {method: random, rows: 0}", "design: rows: 0 refused, must be from 1"),
        ("design: {method: saltelli, rows: 3}", "rows 3 refused: a Saltelli design needs a power"),
        ("design: {method: saltelli, rows: 4}", "method saltelli refused: nothing varies; name"),
        ("design: {rows: 3}", "design: rows: refused: the rows of a grid follow from the counts"),
        ("run: {duration: -1}", "run: duration -1.0 s refused"),
        ("run: {duration: 1.0, since: 2.0}", "run: since: 2 s refused, must be within the run"),
        ("run: {period: fast}", "run: period: 'fast' refused, must be a number"),
        ("run: {period: 1}", "run: period: 1 s refused, longer than valve.command_timeout (0.1 s)"),
        ("traces: {columns: [speed]}", "traces: columns: 'speed' refused, there are time"),
        ("traces: {columns: [position], every: 0}", "traces: every: 0 refused"),
        ("run: {duration: 0.45}", "row 0 of 1: reference.at: 0.5 s refused, the run has ended by"),
        (
            "vary: {reference.at: [0.1, 6.0]}",
            "row 1 of 2: reference.at: 6 s refused, the run",
        ),
        ("vary: {rail.tilt: {from: 1, to: 2, count: 2, factor: true}}", "changes nothing of 0"),
        (
            "set: {cylinder.moving_mass: 3.0}\nvary: {cylinder.moving_mass: [1.0, 2.0]}",
            "vary: cylinder.moving_mass: cylinder.moving_mass is set, too; keep one",
        ),
        ("design: {method: sobol}", "design: rows: missing; give how many rows of a sobol design"),
        (
            "design: {method: sobol, rows: 2}\nvary: {rail.tilt: {from: 0, to: 1, count: 7}}",
            "rail.tilt: count: refused: counts are for grids; design.rows says how many",
        ),
        ("sensors: perfect", "sensors: 'perfect' refused, must be base, ideal or data-sheet"),
        ("vry: {}", "vry: no such field; did you mean vary?"),
        ("[1, 2]", "[1, 2] refused, must be names and values"),
        ("# nothing yet", "is empty, must be names and values"),
        ("run: 0", "run: 0 refused, must be names and values"),
        ("vary: []", "vary: [] refused, must be names and values"),
        ("set: false", "set: False refused, must be names and values"),
        ("vary: {a: [1], a: [2]}", "line 1: 'a' stands twice"),
        ("vary: {", "not YAML"),
    ],
)
def test_a_study_that_cannot_be_done_is_refused_as_a_whole(
    tmp_path: Path, text: str, expected: str
) -> None:
    """In one line that begins with the file and names key, value and the way out."""
    (tmp_path / "arm.yaml").write_text("Plant: {ros__parameters: {supply.pressure: 6.0e+5}}")
    (tmp_path / "two.yaml").write_text(
        "/left/plant: {ros__parameters: {supply.pressure: 6.0e+5}}\n"
        "/right/plant: {ros__parameters: {supply.pressure: 5.0e+5}}\n"
    )
    (tmp_path / "each.yaml").write_text(
        "/left/plant: {ros__parameters: {supply.pressure: 6.0e+5}}\n"
        "/right/controller: {ros__parameters: {controller.kp: 100.0}}\n"
    )
    path = written(tmp_path, text)
    with pytest.raises(StudyError) as refusal:
        read_study(path)
    message = str(refusal.value)
    assert message.startswith(f"{path}: ")
    assert expected in message
    assert "\n" not in message


def test_a_base_with_a_scenario_is_refused(tmp_path: Path) -> None:
    """No run would follow it, and the nodes of a replay would."""
    (tmp_path / "base.yaml").write_text(
        "/**/plant: {ros__parameters: {time.scenario: leak}}\n", encoding="utf-8"
    )
    path = written(tmp_path, "{base: base.yaml, vary: {supply.pressure: [6.0e5]}}")
    said = f"{path}: base: time.scenario: 'leak' refused, no run of a study follows a scenario;"
    with pytest.raises(StudyError, match=f"^{re.escape(said)} leave it out$"):
        read_study(path)


LAW_OF_ONES_OWN = """
from rodless_base.parameters import Parameter, declare
from rodless_control import Law


class Named(Law):
    PARAMETERS = declare(Parameter("supply.pressure", 1.0, "V", "a gain", "own", 0.0, 2.0))

    def update(self, measurement, reference, interval):
        return 5.0


class Broken(Law):
    def __init__(self, parameters):
        raise RuntimeError("no more")

    def update(self, measurement, reference, interval):
        return 5.0


class Exits(Broken):
    def __init__(self, parameters):
        raise SystemExit(7)


class Pair(Law):
    PARAMETERS = declare(
        Parameter("pair.low", 1.0, "V", "the lower", "own", 0.0, 9.0),
        Parameter("pair.high", 2.0, "V", "the higher", "own", 0.0, 9.0),
    )

    def __init__(self, parameters):
        super().__init__(parameters)
        if parameters["pair.low"] > parameters["pair.high"]:
            raise ValueError("low above high")

    def update(self, measurement, reference, interval):
        return 5.0


class Weak(Named):
    PARAMETERS = declare(Parameter("own.gain", 3.0, "V", "a gain", "own", 0.0, 99.0))


class Strong(Named):
    PARAMETERS = declare(Parameter("own.gain", 70.0, "V", "a gain", "own", 0.0, 99.0))
"""

BOTH = "supply.pressure: the rig has it, and laws_of_study:Named too; rename the law's"


@pytest.mark.parametrize(
    ("law", "text", "expected"),
    [
        (
            "Named",
            "{set: {controller.law: LAW}, vary: {supply.pressure: [6.0e5]}}",
            f"vary: supply.pressure: {BOTH}",
        ),
        (
            "Named",
            "{set: {controller.law: LAW}, vary: {supply.p*: [6.0e5]}}",
            f"vary: supply.p*: {BOTH}",
        ),
        ("Named", "set: {supply.pressure: 6.0e5, controller.law: LAW}", f"set: {BOTH}"),
        (
            "Broken",
            "set: {controller.law: LAW}",
            "'laws_of_study:Broken' refused: Broken(parameters) failed: RuntimeError",
        ),
        (
            "Exits",
            "set: {controller.law: LAW}",
            "'laws_of_study:Exits' refused: Exits(parameters) failed: SystemExit: 7",
        ),
        (
            "Pair",
            "{set: {controller.law: LAW}, vary: {pair.low: [1.0, 3.0], pair.high: [4.0, 2.0]}}",
            "study.yaml: row 3 of 4: controller.law: 'laws_of_study:Pair' refused: "
            "Pair(parameters) failed: ValueError: low above high",
        ),
    ],
)
def test_a_law_that_cannot_be_studied_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, law: str, text: str, expected: str
) -> None:
    """One with a parameter of the rig's name that is meant, and one not made of each row.

    Nothing has run by then.
    """
    (tmp_path / "laws_of_study.py").write_text(LAW_OF_ONES_OWN, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    path = written(tmp_path, text.replace("LAW", f"'laws_of_study:{law}'"))
    with pytest.raises(StudyError) as refusal:
        read_study(path)
    assert expected in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_a_factor_multiplies_what_the_law_of_its_row_has(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two laws name a gain alike, and each has a default of its own."""
    (tmp_path / "laws_of_study.py").write_text(LAW_OF_ONES_OWN, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    weak, strong = (f"laws_of_study:{name}" for name in ("Weak", "Strong"))
    gain = "{from: 0.5, to: 1.0, count: 2, factor: true}"
    laws = f"['{weak}', '{strong}']"
    study = read_study(written(tmp_path, f"vary: {{controller.law: {laws}, own.gain: {gain}}}"))
    found = [study.row(number).base.controller for number in range(len(study))]
    assert [(one.text("controller.law"), one.number("own.gain")) for one in found] == [
        *((weak, 1.5), (weak, 3.0), (strong, 35.0), (strong, 70.0)),
    ]


@pytest.mark.parametrize(
    "text",
    [
        "vary: {%s: [1]}",
        "%s: 1",
        "vary: {supply.pressure: {from: 1, to: 2, %s: 3}}",
        "vary: {supply.pressure: {from: 1, to: 2, scale: %s}}",
        "set: {%s: 1}",
        "set: {cylinder.model: %s}",
        "base: %s",
        "sensors: %s",
        "design: {method: %s}",
    ],
)
def test_a_long_text_is_refused_in_a_line_that_can_be_read(tmp_path: Path, text: str) -> None:
    """What is longer than a line is cut in its middle, wherever it stands."""
    with pytest.raises(StudyError, match=r"xxx\.\.\.xxx") as refusal:
        read_study(written(tmp_path, text % ("x" * 900)))
    assert len(str(refusal.value)) < 850


def test_a_study_that_is_not_there_is_refused_with_those_there_are(tmp_path: Path) -> None:
    """A file by its path, a name by those that ship."""
    with pytest.raises(StudyError, match="cannot be read: No such file"):
        read_study(tmp_path / "none.yaml")
    with pytest.raises(
        StudyError, match=r"'none': refused, must be a file \.yaml or \.yml, or one of "
    ):
        read_study("none")
