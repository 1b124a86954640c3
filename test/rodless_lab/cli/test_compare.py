# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Two runs compared: numbers by hand, and the command end to end."""

import json
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import rig_bag
from no_room import fill_up
from quiet_stop import Quiet

from rodless_base.constants import SUPPLY_PRESSURE
from rodless_control import PidParameters, references
from rodless_lab import closed_loop
from rodless_lab.cli import animate, compare, replay
from rodless_lab.figures.animation import Film
from rodless_lab.runs.comparison import common_time, difference
from rodless_lab.runs.measured_run import run_of_trace
from rodless_sim import RigParameters, State, Trace, simulate


def record(path: Path, run: Trace, target: float | None = None, late: float = 0.0) -> Path:
    """Write a run as a bag, begun ``late`` s earlier on the clock, with a set-point at 0.2 s."""
    measured = run_of_trace(
        Trace(**{**{name: getattr(run, name) for name in FIELDS}, "time": run.time + late}),
        SUPPLY_PRESSURE,
    )
    return rig_bag.write(path, measured, setpoint=target and (0.2 + late, target))


def step_run(preset: str, at: float = 0.2) -> Trace:
    """Return a step of section 6.2, 1.5 s of it."""
    return closed_loop(
        RigParameters.preset(preset),
        PidParameters.preset(preset),
        references.step(0.0, 0.058, at=at),
        duration=1.5,
        period=1e-3,
    )


def compared(*arguments: str | Path, output: Path) -> dict[str, dict[str, float]]:
    """Run the command and return the differences it wrote."""
    code = compare.main([*map(str, arguments), "--output", str(output)], Quiet())
    assert code == 0
    assert (output / "compare.png").read_bytes().startswith(b"\x89PNG")
    written = json.loads((output / "compare.json").read_text(encoding="utf-8"))
    return written["differences"]


@pytest.mark.parametrize(("verb", "arguments"), [(compare, ["paper"]), (replay, [])])
def test_a_full_disk_is_named_with_its_file_and_leaves_no_folder(
    verb: ModuleType,
    arguments: list[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Code 2; with room for one file of the two there is neither, and with room for both, both."""
    bag = record(tmp_path / "bag", simulate(RigParameters(), [6.0] * 200, 1e-3))
    output = tmp_path / "new" / "out"
    call = [*arguments, str(bag), "--output", str(output)]
    with monkeypatch.context() as patch:
        fill_up(patch, room=1)
        assert verb.main(call, Quiet()) == 2
    said = capsys.readouterr().err.splitlines()[-1]
    assert said.endswith(".json: cannot be written: No space left on device")
    assert [path.name for path in tmp_path.iterdir()] == ["bag"]
    assert verb.main(call, Quiet()) == 0
    assert len(list(output.iterdir())) == 2


def test_differences_by_hand() -> None:
    """Ten seconds apart by 1 mm, but for 3 mm at 4 s and 0.2 mm over the last second."""
    time = np.linspace(0.0, 10.0, 1001)
    apart = np.full(1001, 1e-3)
    apart[400] = -3e-3
    apart[time > 9.0] = 2e-4
    found = difference(time, np.zeros(1001), apart)
    assert found.steady == pytest.approx(2e-4)
    assert found.largest == pytest.approx(3e-3)
    assert found.time == pytest.approx(4.0)
    # 900 samples of 1 mm, one of 3 mm, 100 of 0.2 mm.
    assert found.rms == pytest.approx(np.sqrt((900 * 1.0 + 9.0 + 100 * 0.04) / 1001) * 1e-3)


def test_common_time_is_the_overlap_of_both_on_the_coarser_base() -> None:
    """0 to 2 s in ms and 1 to 3 s in steps of 10 ms have 1 to 2 s in common: 101 samples."""
    time = common_time(np.arange(2001) * 1e-3, 1.0 + np.arange(201) * 1e-2)
    assert time == pytest.approx(1.0 + np.arange(101) * 1e-2)


def test_a_preset_driven_by_a_bags_voltages_repeats_the_bag(tmp_path: Path) -> None:
    """The same preset, supply and voltages give the recorded run, to the last digit."""
    voltages = np.repeat([5.6, 4.7, 5.3], 400)
    run = simulate(RigParameters(), voltages, 1e-3, position=0.08)
    found = compared("paper", record(tmp_path / "bag", run), output=tmp_path / "out")
    assert found["position"]["largest"] < 1e-9
    assert found["pressure_a"]["largest"] < 1e-3


def test_what_drives_a_run_is_no_difference(tmp_path: Path) -> None:
    """The last voltage of a bag acts on nothing in it; fed to the plant it is still the same."""
    run = simulate(RigParameters(), np.repeat([5.6, 4.7], 400), 1e-3, position=0.08)
    run = Trace(**{**run.columns(), "voltage": np.append(run.voltage[:-1], 6.2)})
    bag = record(tmp_path / "bag", run)
    found = compared("paper", bag, output=tmp_path / "out")
    assert found["voltage"]["largest"] < 1e-9
    replayed = ["--output", str(tmp_path / "replay")]
    assert replay.main([str(bag), *replayed], Quiet()) == 0
    written = json.loads((tmp_path / "replay" / "replay.json").read_text(encoding="utf-8"))
    assert written["voltage"]["largest"] < 1e-9
    assert written["position"]["largest"] < 1e-9


def test_a_preset_cannot_stand_second(tmp_path: Path, capsys) -> None:
    """The message says what may stand where."""
    arguments = ["paper", "paper", "--output", str(tmp_path / "out")]
    assert compare.main(arguments, Quiet()) == 2
    assert "a preset can only stand first" in capsys.readouterr().err


def test_a_preset_driven_by_set_points_repeats_the_bag(tmp_path: Path) -> None:
    """The preset's own controller on the recorded set-points repeats a run in closed loop.

    Until the first set-point, 0.2 s after the start, the carriage stays where it is.
    """
    bag = record(tmp_path / "bag", step_run("paper", at=0.2), target=0.058)
    run = compared("calibrated", bag, "--drive", "setpoint", output=tmp_path / "other")
    assert run["position"]["largest"] > 5e-3
    same = compared("paper", bag, "--drive", "setpoint", output=tmp_path / "same")
    assert same["position"]["largest"] < 1e-9


def test_difference_of_two_presets_is_that_of_their_runs(tmp_path: Path) -> None:
    """Two bags: the largest difference is that of the arrays they were written from."""
    first, second = step_run("paper"), step_run("calibrated")
    found = compared(
        record(tmp_path / "first", first),
        record(tmp_path / "second", second),
        output=tmp_path / "out",
    )
    apart = second.position - first.position
    assert found["position"]["largest"] == pytest.approx(np.abs(apart).max())
    assert found["position"]["time"] == pytest.approx(first.time[np.argmax(np.abs(apart))])
    assert found["position"]["steady"] == pytest.approx(apart[-151:].mean(), rel=0.02)


def test_bags_begun_at_different_times_are_aligned_by_their_set_points(tmp_path: Path) -> None:
    """One recording began 0.1 s earlier before its step: with set-points they still agree."""
    run = step_run("paper")
    cut = Trace(**{name: values[100:] for name, values in run.columns().items() if name in FIELDS})
    found = compared(
        record(tmp_path / "whole", run, target=0.058),
        record(tmp_path / "cut", cut, target=0.058),
        output=tmp_path / "out",
    )
    assert found["position"]["largest"] < 1e-9


@pytest.mark.parametrize("clock", [lambda _: 0.0, lambda time: 2e-9 * round(1e3 * time)])
def test_set_points_that_no_time_dates_align_nothing(tmp_path: Path, capsys, clock) -> None:
    """Log times at zero, or that count: said in a line, and both runs are laid on their starts."""
    measured = run_of_trace(step_run("paper"), SUPPLY_PRESSURE)
    whole = rig_bag.write(tmp_path / "whole", measured, setpoint=(0.2, 0.058), held=True)
    timeless = rig_bag.write(
        tmp_path / "timeless", measured, setpoint=(0.2, 0.058), clock=clock, held=True
    )
    for pair in ((whole, timeless), (timeless, whole)):
        assert compared(*pair, output=tmp_path / "out")["position"]["largest"] < 1e-9
        said = capsys.readouterr().err
        assert "timeless: /setpoint: 1501 samples share 1 " in said
        assert "so it is not known when set-points were given" in said
    driven = ["paper", str(timeless), "--drive", "setpoint", "--output", str(tmp_path / "driven")]
    assert compare.main(driven, Quiet()) == 2
    assert "or compare with --drive voltage" in capsys.readouterr().err
    assert not (tmp_path / "driven").exists()


@pytest.mark.parametrize("speed", [0.01, 1.0, 100.0])
def test_a_clock_of_any_speed_aligns_by_set_points(tmp_path: Path, capsys, speed: float) -> None:
    """Slow and fast simulations have other log times than stamps: nothing is odd about that."""
    whole = rig_bag.write(
        tmp_path / "bag",
        run_of_trace(step_run("paper"), SUPPLY_PRESSURE),
        setpoint=(0.2, 0.058),
        clock=lambda time: 1e9 + time / speed,
    )
    found = compared("paper", whole, "--drive", "setpoint", output=tmp_path / "out")
    assert found["position"]["largest"] < 1e-9
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    ("scale", "said"),
    [
        (1.0, ""),
        (40.0, ""),
        (1e3, "positions leave -1 to 10 m, at 0.000 s with 50 m; they must be in m, and may be in"),
        (-1e3, "positions leave -1 to 10 m, at 0.000 s with -50 m; they must be in m, and may b"),
        (1e30, "positions leave -1 to 10 m, at 0.000 s with 5e+28 m; they must be in m, and may"),
    ],
)
def test_positions_of_no_rig_are_told(tmp_path: Path, capsys, scale: float, said: str) -> None:
    """In mm, for example: compare and replay go on, and say so; and where a replay cannot start."""
    run = simulate(RigParameters(), [5.4] * 600, 1e-3, position=0.05)
    bag = record(tmp_path / "bag", Trace(**{**run.columns(), "position": scale * run.position}))
    for command, first in ((compare, ["paper"]), (compare, [str(bag)]), (replay, [])):
        output = ["--output", str(tmp_path / "out")]
        assert command.main([*first, str(bag), *output], Quiet()) == 0
        error = capsys.readouterr().err
        elsewhere = scale == 40.0 and str(bag) not in first
        line = f"{bag}: /joint_states: {said}" if said else ""
        assert error.startswith("the simulated carriage starts at 200 mm" if elsewhere else line)
        assert error.count("\n") == bool(said or elsewhere)


FIELDS = tuple(State._fields)


def test_set_points_that_were_not_recorded(tmp_path: Path, capsys) -> None:
    """Asked to drive by set-points a bag does not hold: said, code 2, nothing written."""
    bag = record(tmp_path / "bag", simulate(RigParameters(), [5.3] * 100, 1e-3))
    output = tmp_path / "out"
    arguments = ["paper", str(bag), "--drive", "setpoint", "--output", str(output)]
    assert compare.main(arguments, Quiet()) == 2
    assert "no set-points that are numbers were recorded" in capsys.readouterr().err
    assert not output.exists()


def test_two_bags_have_nothing_to_drive(tmp_path: Path, capsys) -> None:
    """--drive was dropped without a word."""
    bag = record(tmp_path / "bag", simulate(RigParameters(), [5.3] * 100, 1e-3))
    arguments = [str(bag), str(bag), "--drive", "voltage", "--output", str(tmp_path / "out")]
    assert compare.main(arguments, Quiet()) == 2
    assert "--drive: refused for two bags" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_table_shows_the_papers_two_numbers(tmp_path: Path, capsys) -> None:
    """The table names both runs, and gives steady-state and largest difference in mm."""
    run = simulate(RigParameters(), [5.4] * 600, 1e-3, position=0.05)
    shifted = Trace(**{**run.columns(), "position": run.position + 1.5e-4})
    first, second = record(tmp_path / "model", run), record(tmp_path / "rig", shifted)
    compared(first, second, output=tmp_path / "out")
    shown = capsys.readouterr().out
    assert "rig minus model" in shown
    row = next(line for line in shown.splitlines() if line.startswith("position"))
    assert row.split()[1:3] == ["0.150", "0.150"]
    assert row.endswith("mm")


def test_results_that_replace_earlier_ones_say_so(tmp_path: Path, capsys) -> None:
    """The second time, by compare and by replay; not the first."""
    bag = record(tmp_path / "bag", simulate(RigParameters(), [5.3] * 300, 1e-3))
    for command, first in ((compare, ["paper", str(bag)]), (replay, [str(bag)])):
        said = []
        for _ in range(2):
            assert command.main([*first, "--output", str(tmp_path / "out")], Quiet()) == 0
            said.append(capsys.readouterr().out.splitlines()[-1])
        assert said[1] == f"{said[0]}, in place of earlier ones"


def test_a_bag_where_one_stands_has_the_name_of_its_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Given as a dot it had none, in the table and the numbers, and above the moving picture."""
    bag = record(tmp_path / "model", simulate(RigParameters(), [5.3] * 100, 1e-3))
    monkeypatch.chdir(bag)
    assert compare.main([".", str(bag), "--output", str(tmp_path / "out")], Quiet()) == 0
    written = json.loads((tmp_path / "out" / "compare.json").read_text(encoding="utf-8"))
    assert (written["first"], written["second"]) == ("model", "model")
    titles: list[str] = []

    def write(file: Path, _run: object, _setpoint: object, _stroke: float, film: Film) -> int:
        file.touch()
        titles.append(film.title)
        return 0

    monkeypatch.setattr(animate, "write_animation", write)
    assert animate.main([".", "--output", str(tmp_path / "run.gif")], Quiet()) == 0
    assert titles == ["model"]


def test_a_replay_follows_no_scenario(tmp_path: Path, capsys) -> None:
    """One in the parameter file was passed over without a word."""
    file = tmp_path / "plant.yaml"
    file.write_text("/**/plant: {ros__parameters: {time.scenario: leak}}\n", encoding="utf-8")
    arguments = [str(tmp_path), "--parameters", str(file), "--output", str(tmp_path / "out")]
    assert replay.main(arguments, Quiet()) == 2
    refusal = "time.scenario: 'leak' refused, a replay does what the bag says; leave it out"
    assert capsys.readouterr().err == f"{file}: {refusal}\n"


@pytest.mark.parametrize("drive", ["voltage", "setpoint"])
def test_a_recording_that_begins_amid_a_move_says_what_it_is_compared_with(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], drive: str
) -> None:
    """The preset starts at rest: with the very rig that was recorded it is millimetres apart.

    From the start on it is not, nor is a replay, which starts with the recorded pressures.
    """
    whole = step_run("paper")
    begun = 210  # 10 ms after the step
    rest = Trace(**{name: getattr(whole, name)[begun:] for name in (*FIELDS, "time")})
    for name, run in (("whole", whole), ("rest", rest)):
        bag = record(tmp_path / name, run, target=0.058)
        out = tmp_path / f"out_{name}"
        found = compared("paper", bag, "--drive", drive, output=out)["position"]["largest"]
        said = capsys.readouterr().err
        a, b = 1e-3 * run.pressure_a[0], 1e-3 * run.pressure_b[0]
        line = f"445 kPa in A and 445 kPa in B, the recorded one with {a:.0f} and {b:.0f} kPa"
        assert (line in said) == (name == "rest")
        assert (found > 1e-4) == (name == "rest")
        assert replay.main([str(bag), "--output", str(out)], Quiet()) == 0
        assert "in B, the recorded one" not in capsys.readouterr().err
