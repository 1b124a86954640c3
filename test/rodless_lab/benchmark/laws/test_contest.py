# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The contest of laws: what its tasks do to a rig, its figures, and what the command writes."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest
from quiet_stop import Quiet

from rodless_base.parameter_file import preset_directory
from rodless_control import Law, ParameterError, references
from rodless_control.laws import LAWS
from rodless_lab.benchmark.laws.contest import Score, contest, score
from rodless_lab.benchmark.laws.entries import Entry, entry, of_package, users
from rodless_lab.benchmark.laws.tables import markdown, rows
from rodless_lab.benchmark.laws.tasks import FRICTION, Steps, Task, random_steps, rigs, tasks
from rodless_lab.cli.laws import MOST_RIGS, main
from rodless_lab.simulation.ensemble import Ensemble
from rodless_lab.simulation.run_metrics import NO_METRICS
from rodless_sim import RigParameters

SHORT = Task("short", references.step(0.0, 0.01, at=0.05), 0.3)


class Watching(Law):
    """Keeps the valve closed and remembers what it has read."""

    def reset(self) -> None:
        """Forget what was read."""
        self.read: list[tuple[int, float]] = []

    def update(self, measurement, reference, interval):  # type: ignore[no-untyped-def]  # noqa: ARG002
        """Take note of stamp and supply pressure."""
        self.read.append((measurement.stamp, measurement.supply_pressure))
        return 5.08


def test_readings_come_late_and_the_rig_changes_on_the_way() -> None:
    """5 ms late, the first one until then; the supply falls at 0.1 s to four fifths."""
    law, (rig,) = Watching(), rigs(1, 1)
    task = Task(
        "late",
        SHORT.reference,
        0.2,
        ideal=True,
        delay=5e-3,
        factors={"supply.pressure": 0.8},
        at=0.1,
    )
    score(Entry("watching", law), task, [rig])
    stamps, supply = (np.array(column) for column in zip(*law.read, strict=True))
    assert stamps.tolist() == [k * 1_000_000 for k in range(201)]  # those of the samples
    full = rig.number("supply.pressure")
    assert supply[:105].tolist() == [full] * 105
    assert supply[105:] == pytest.approx(0.8 * full, rel=1e-12)


def test_a_task_begins_with_its_own_rig() -> None:
    """The instruments of the paper unless ideal; factors from 0 s on are there from the start."""
    (drawn,) = rigs(1, 1)
    noisy, ideal = SHORT.rig(drawn), Task("", SHORT.reference, 1.0, ideal=True).rig(drawn)
    assert (noisy["sensors.position_noise"], ideal["sensors.position_noise"]) == (2e-5, 0.0)
    half = Task("", SHORT.reference, 1.0, factors=dict.fromkeys(FRICTION, 0.5)).rig(drawn)
    for name in FRICTION:
        assert half.number(name) == 0.5 * drawn.number(name)
    later = Task("", SHORT.reference, 1.0, factors={"supply.pressure": 0.8}, at=0.5)
    assert later.rig(drawn)["supply.pressure"] == drawn["supply.pressure"]


def test_the_rigs_are_drawn_by_their_seed_in_the_ranges() -> None:
    """The same each time; every friction that a rig has is varied, and halved by its task."""
    base = RigParameters.preset("calibrated")
    drawn = rigs(20, 3)
    assert drawn == rigs(20, 3) != rigs(20, 4)
    for rig in drawn:
        assert 0.7 <= rig.number("cylinder.moving_mass") <= 2.0
        assert 501325.0 <= rig.number("supply.pressure") <= 701325.0
        assert 10e-6 <= rig.number("cylinder.dead_volume_a") <= 30e-6
        for name in FRICTION:
            assert 0.7 <= rig.number(name) / base.number(name) <= 1.3
            assert rig.number(name) != base.number(name)


def test_steps_jump_at_their_times() -> None:
    """The target holds from its time on; random ones are on the stroke, by their seed."""
    steps = Steps(0.0, (0.1, 1.5), (0.058, 0.02))
    assert [steps.sample(t)[0] for t in (0.0, 0.0999, 0.1, 1.4, 1.5, 9.0)] == [
        0.0,
        0.0,
        0.058,
        0.058,
        0.02,
        0.02,
    ]
    drawn = random_steps(5)
    assert drawn == random_steps(5) != random_steps(6)
    assert all(0.02 <= target <= 0.18 for target in drawn.positions)


def test_what_never_comes_counts_as_infinite() -> None:
    """Of three runs one has not settled: the median is known, the worst is not."""
    runs = [NO_METRICS._replace(settling_time=value) for value in (0.3, math.nan, 0.2)]
    score = Score(entry("pid"), SHORT, Ensemble(runs, {}))
    assert score.quantiles("settling_time") == (0.3, math.inf, math.inf)
    assert score.count("settling_time", 0.25) == 2


def test_every_task_has_a_name_of_its_own_and_a_row_for_each_law() -> None:
    """Two laws at all tasks of a shortened list, in the order of the tasks."""
    names = [task.name for task in tasks(1)]
    assert len(set(names)) == len(names) >= 11
    entries = [entry("pid"), Entry("another", entry("pid").law)]
    begun: list[str] = []
    scores = contest(entries, [SHORT], rigs(2, 1), begun.append, lambda: False)
    lines = markdown(scores).splitlines()
    assert begun == ["short"]
    assert [line.split("|")[1:3] for line in lines[-2:]] == [
        [" short ", " pid "],
        ["  ", " another "],
    ]
    assert contest(entries, [SHORT], rigs(2, 1), begun.append, lambda: True) == []


def test_a_run_without_figures_is_named() -> None:
    """In the page with the reason of the first, in the CSV each with its own."""
    failures = {0: "at 0.1 s: law Mine answered nan V, twice", 2: "beyond its stroke"}
    runs = Ensemble([NO_METRICS] * 3, failures)
    scores = [Score(Entry("mine", entry("pid").law), SHORT, runs)]
    expected = (
        "- mine, short: 2 of 3, the first with rig 0: at 0.1 s: law Mine answered nan V, twice"
    )
    assert markdown(scores).splitlines()[-1] == expected
    lines = list(csv.DictReader(rows(scores).splitlines()))
    assert [line["failure"] for line in lines] == [failures[0], "", failures[2]]


def test_a_law_of_the_package_has_the_gains_that_the_table_shows() -> None:
    """Named alone it competes as it does among all, and once however often it is named."""
    for one in of_package():
        (found,) = users([one.name] * 2)
        assert found.law.parameters == one.law.parameters


def test_the_laws_that_compete(tmp_path: Path) -> None:
    """All of the package; one's own by name and file, and refusals in one line."""
    found = of_package()
    names = [one.name for one in found]
    assert names == list(LAWS)
    assert found[0].law.parameters["controller.filter"] == "fading_memory"
    switching = found[names.index("mode_switching")].law.parameters
    assert switching["controller.kp"] == found[0].law.parameters["controller.kp"]
    assert switching["cascade.mass"] != switching.DECLARATIONS["cascade.mass"].default
    named = tmp_path / "rig1.yaml"
    named.write_text("/rig1/controller: {ros__parameters: {controller.kp: 321.0}}")
    assert users([f"pid={named}"])[0].law.parameters["controller.kp"] == 321.0
    plant = preset_directory() / "sensors" / "data_sheet.yaml"
    with pytest.raises(ParameterError, match=r"it has no parameters of a controller$"):
        users([f"pid={plant}"])
    with pytest.raises(
        ParameterError, match="tunes other laws and has none of the parameters of adrc; with"
    ):
        users([f"adrc={named}"])
    with pytest.raises(ParameterError, match="pid=: refused, no file after ="):
        users(["pid="])
    with pytest.raises(ParameterError, match="no_such_module"):
        users(["no_such_module:Law"])
    with pytest.raises(
        ParameterError, match="'cascade' refused: these are the parameters of 'pid'"
    ):
        users([f"pid={preset_directory() / 'laws' / 'cascade.yaml'}"])


def test_the_command_writes_table_picture_and_every_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One rig, one law: each task has a row in the table and one in the CSV."""
    assert main(["--rigs", "1", "--law", "pid", "--output", str(tmp_path)], Quiet()) == 0
    table = (tmp_path / "laws.md").read_text(encoding="utf-8")
    assert table in capsys.readouterr().out
    assert (tmp_path / "laws.png").stat().st_size > 10_000
    with (tmp_path / "runs.csv").open(encoding="utf-8", newline="") as file:
        runs = list(csv.DictReader(file))
    assert [run["task"].replace(";", ",") for run in runs] == [task.name for task in tasks(1)]
    assert all(task.name in table for task in tasks(1))
    assert all(math.isfinite(float(run["rms_error"])) for run in runs)


def test_bad_options_are_refused_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A law that there is not, and a file that there is not: exit code 2, one line."""
    for law in ("pud", f"pid={tmp_path / 'missing.yaml'}"):
        assert main(["--law", law, "--output", str(tmp_path)], Quiet()) == 2
        assert len(capsys.readouterr().err.splitlines()) == 1
    with pytest.raises(SystemExit):
        main(["--rigs", "0"], Quiet())


def test_more_rigs_than_fit_into_memory_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """By the command line, in one line with value and bound: before, 10 million took 38 GB."""
    for rigs_wanted in (MOST_RIGS + 1, 10_000_001):
        with pytest.raises(SystemExit) as ended:
            main(["--rigs", str(rigs_wanted), "--output", str(tmp_path / "out")], Quiet())
        assert ended.value.code == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert f"--rigs: {rigs_wanted} refused, must be 100000 or less" in line
    assert not (tmp_path / "out").exists()


def test_a_seed_that_draws_nothing_is_refused_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Code 2 and the bound; it was a traceback. No folder is made."""
    arguments = ["--seed", "3000000000", "--law", "pid", "--output", str(tmp_path / "out")]
    assert main(arguments, Quiet()) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line == "seed 3000000000 refused: must be a whole number from 0 to 2147483647"
    assert not (tmp_path / "out").exists()
