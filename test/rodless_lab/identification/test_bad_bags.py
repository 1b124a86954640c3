# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Bags that cannot be used: a message that says what and where, code 2, and no file."""

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from no_room import fill_up
from quiet_stop import Quiet

from rodless_lab.cli import compare, identify
from rodless_lab.identification.bristles.fit import identify_bristles
from rodless_lab.identification.friction.run import identify_friction
from rodless_lab.identification.plausible import check_run
from rodless_lab.identification.pressures.chambers import identify_chambers
from rodless_lab.identification.pressures.heat import identify_heat
from rodless_lab.runs.measured_run import (
    MeasuredRun,
    RunError,
    UninformativeRunError,
    run_of_trace,
)
from rodless_sim import RigParameters, simulate
from rodless_sim.instruments.instruments import DATA_SHEET


def a_run(samples: int = 400) -> MeasuredRun:
    time = np.arange(samples) * 1e-3
    level = np.full(samples, 4e5)
    varying, voltage = level + 10.0 * np.sin(2.0 * np.pi * 50.0 * time), np.full(samples, 5.3)
    return MeasuredRun(time, 0.1 + 0.01 * time, varying, level, level + 2e5, voltage)


@pytest.mark.parametrize("difference", [0.0, 5e4, 1234.567])
@pytest.mark.parametrize(
    "identified", [identify_friction, identify_bristles, identify_chambers, identify_heat]
)
def test_pressures_that_never_change_are_no_measurement(
    difference: float, identified: Callable[[MeasuredRun, RigParameters], object]
) -> None:
    """Stuck transmitters, or one read for both, would make friction of any size."""
    run = a_run(4000)
    stuck = replace(run, pressure_b=run.pressure_a - difference)
    said = rf"^pressure_a is {difference:g} Pa above pressure_b in all samples, while the carriage"
    with pytest.raises(RunError, match=said):
        identified(stuck, RigParameters())


def test_a_carriage_that_rests_may_have_constant_pressures() -> None:
    """It informs nothing of friction, and no sensor is blamed."""
    run = a_run(4000)
    still = replace(run, position=np.full(4000, 0.1), pressure_b=run.pressure_a)
    with pytest.raises(UninformativeRunError, match="no uniform motion"):
        identify_friction(still, RigParameters())


def test_one_pressure_that_never_changes_is_told(tmp_path: Path, write_bag, capsys) -> None:
    """It may be stated, as of one sensor for the difference; a stuck one makes nonsense."""
    run = sliding_run()
    bag = write_bag(tmp_path / "bag", run)
    assert np.ptp(run.pressure_b) == 0.0
    identify.main(["friction", str(bag), "-o", str(tmp_path / "found.yaml")], Quiet())
    assert "pressure_b is 400000 Pa in all samples, while the carr" in capsys.readouterr().err


def steady_run(noise: float) -> MeasuredRun:
    """An ideal rig on four constant voltages, its pressures read with ``noise`` (Pa)."""
    voltages = np.repeat([5.4, 5.5, 5.6, 5.7], 1500)
    run = run_of_trace(simulate(RigParameters(), voltages, 1e-3, position=0.01), 621325.0)
    read = np.random.default_rng(1).normal(0.0, noise, (2, len(run.time)))
    return replace(run, pressure_a=run.pressure_a + read[0], pressure_b=run.pressure_b + read[1])


@pytest.mark.parametrize(("first", "last"), [(0, 4000), (3000, 5000), (3000, 6001), (0, 6000)])
@pytest.mark.parametrize("name", ["pressure_a", "pressure_b"])
def test_a_pressure_that_is_frozen_for_a_while_is_refused(first: int, last: int, name: str) -> None:
    """Its noise ends at once, or begins; while an ideal rig settles to the last bit."""
    known, noisy = RigParameters(), steady_run(200.0)
    coarse = steady_run(20.0)
    coarse = replace(coarse, **{name: 1220.0 * np.rint(getattr(coarse, name) / 1220.0)})
    for sound in (noisy, steady_run(0.0), coarse):
        check_run(sound, known, absolute=False)
    frozen = getattr(noisy, name).copy()
    frozen[first:last] = frozen[first]
    begin, end = noisy.time[first], noisy.time[last - 1]
    said = f"^{name} is {frozen[first]:.6g} Pa from {begin:.6g} to {end:.6g} s, while the carriage"
    with pytest.raises(RunError, match=said):
        check_run(replace(noisy, **{name: frozen}), known, absolute=False)


@pytest.mark.parametrize("period", [1e-3, 5e-3, 10e-3])
@pytest.mark.parametrize("turned", [0.0, 4.5, 7.0])
def test_a_valve_that_turns_after_the_pressures_settled_froze_no_sensor(
    turned: float, period: float
) -> None:
    """An ideal rig at full speed settles to the last bit, and leaves that where the valve turns."""
    time = np.arange(0.0, 8.0, period)
    voltages = 5.0 + 0.8 * np.sin(2.0 * np.pi * 3.0 * time)
    voltages[(time >= 2.0) & (time < 3.0)] = 10.0
    voltages[(time >= 3.0) & (time < 3.2)] = turned
    run = run_of_trace(simulate(RigParameters(), voltages, period, position=0.1), 621325.0)
    first_of_full, last_of_full = round(2.0 / period), round(3.0 / period)
    settled = slice(last_of_full - round(0.4 / period), last_of_full)
    assert np.ptp(run.pressure_a[settled]) == 0.0
    assert np.ptp(run.position[settled]) > 0.02
    check_run(run, RigParameters(), absolute=False)
    frozen = run.pressure_a.copy()
    frozen[first_of_full:last_of_full] = frozen[first_of_full]
    with pytest.raises(RunError, match="its sensor was frozen, or samples were lost"):
        check_run(replace(run, pressure_a=frozen), RigParameters(), absolute=False)


def test_a_position_that_is_frozen_for_a_while_is_refused() -> None:
    """It stands still, and is elsewhere within a sample; one that rests and starts is not."""
    run = sliding_run()
    check_run(run, RigParameters(), absolute=False)
    resting = run.position.copy()
    resting[1000:1500] = resting[1000]
    resting[1500:] += resting[1000] - resting[1500]
    check_run(replace(run, position=resting), RigParameters(), absolute=False)
    frozen = run.position.copy()
    frozen[1000:2500] = frozen[1000]
    with pytest.raises(
        RunError, match=r"at sample 2500, at 2\.5 s, jumps by 20 mm: its sensor was"
    ):
        check_run(replace(run, position=frozen), RigParameters(), absolute=False)


def test_a_force_within_the_bias_is_no_friction() -> None:
    """Both sensors at one chamber: what they differ by is their noise, whatever friction is."""
    run, noise = sliding_run(), np.random.default_rng(1).normal(0.0, 60.0, (2, 3000))
    both = replace(run, pressure_a=run.pressure_a + noise[0], pressure_b=run.pressure_a + noise[1])
    with pytest.raises(UninformativeRunError, match=r"less than the 4\.21 N that a bias of their"):
        identify_friction(both, RigParameters(DATA_SHEET))
    assert identify_friction(run, RigParameters(DATA_SHEET)).forward.coulomb.informed


def test_friction_that_would_push_is_not_found() -> None:
    """The force is against the motion: no interval reversed at the bound of the range."""
    run = sliding_run()
    pushed = replace(run, pressure_a=2.0 * run.pressure_b - run.pressure_a)
    for sensors in ({}, DATA_SHEET):
        fit = identify_friction(pushed, RigParameters(sensors))
        assert not fit.forward.coulomb.informed
        assert "and can be from 0 to" in fit.forward.coulomb.note
        assert not fit.verdict.fits
        assert "the model does not fit: force that drives the carriage forward" in str(fit.verdict)


def refused(
    bag: Path, folder: Path, capsys: pytest.CaptureFixture[str], subject: str = "friction"
) -> str:
    """Run the command, hold what every refusal must keep, and return the message."""
    output = folder / "out" / "found.yaml"
    code = identify.main([subject, str(bag), "-o", str(output)], Quiet())
    error = capsys.readouterr().err
    assert code == 2
    assert "Traceback" not in error
    assert bag.name in error
    assert not output.exists()
    assert not (folder / "out").exists() or not list((folder / "out").iterdir())
    return error


@pytest.mark.parametrize("subject", ["friction", "valve", "chambers"])
def test_missing_bag(tmp_path: Path, capsys: pytest.CaptureFixture[str], subject: str) -> None:
    """There is no such folder, whatever is to be identified."""
    assert "no such bag" in refused(tmp_path / "nothing", tmp_path, capsys, subject)


def test_bag_without_messages(tmp_path: Path, write_bag, capsys) -> None:
    """Recorded while nobody published: the first topic looked for is named."""
    bag = write_bag(tmp_path / "bag", a_run(), spoil=lambda *_: None)
    message = refused(bag, tmp_path, capsys)
    assert "/joint_states was not recorded; the bag holds no topics" in message


def test_topic_without_messages(tmp_path: Path, write_bag, capsys) -> None:
    """One topic was announced, and never spoken on, while the others were."""
    bag = write_bag(
        tmp_path / "bag",
        a_run(),
        spoil=lambda topic, _, time, good: None if topic == "/supply/pressure" else (time, good),
    )
    assert "/supply/pressure holds no message" in refused(bag, tmp_path, capsys)


def test_empty_folder(tmp_path: Path, capsys) -> None:
    """A folder without a storage file is no bag."""
    (tmp_path / "bag").mkdir()
    assert "not a bag" in refused(tmp_path / "bag", tmp_path, capsys)


def test_truncated_bag(tmp_path: Path, write_bag, capsys) -> None:
    """A storage file cut in the middle: said, with what could still be recovered."""
    bag = write_bag(tmp_path / "bag", a_run())
    (file,) = bag.glob("*.mcap")
    content = file.read_bytes()
    file.write_bytes(content[: len(content) // 2])
    assert "can be recovered" in refused(bag, tmp_path, capsys)


@pytest.mark.parametrize(
    "topic",
    [
        "/joint_states",
        "/chamber_a/pressure",
        "/chamber_b/pressure",
        "/supply/pressure",
        "/valve/voltage",
    ],
)
def test_missing_topic(tmp_path: Path, write_bag, capsys, topic: str) -> None:
    """The topic that was not recorded is named, and so is what the bag holds instead."""
    bag = write_bag(tmp_path / "bag", a_run(), without=topic)
    message = refused(bag, tmp_path, capsys)
    assert f"{topic} was not recorded" in message
    assert "the bag holds" in message


@pytest.mark.parametrize("topic", ["/joint_states", "/chamber_b/pressure", "/valve/voltage"])
@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_value_that_is_not_finite(
    tmp_path: Path, write_bag, capsys, topic: str, value: float
) -> None:
    """Message 250, at 0.25 s, carries NaN or infinity: topic, message and time are named."""
    bag = write_bag(
        tmp_path / "bag",
        a_run(),
        spoil=lambda where, k, time, good: (time, value if (where, k) == (topic, 250) else good),
    )
    message = refused(bag, tmp_path, capsys)
    assert f"{topic}: message 250, at 0.250000 s, holds {value}" in message


@pytest.mark.parametrize("topic", ["/joint_states", "/supply/pressure", "/valve/voltage"])
def test_time_going_backwards(tmp_path: Path, write_bag, capsys, topic: str) -> None:
    """From message 300 on the clock is 0.2 s behind, as after a reset: the place is named."""
    bag = write_bag(
        tmp_path / "bag",
        a_run(),
        spoil=lambda where, k, time, good: (
            time - 0.2 if where == topic and k >= 300 else time,
            good,
        ),
    )
    message = refused(bag, tmp_path, capsys)
    assert f"{topic}: time goes backwards at message 300" in message
    assert "from 0.299000 s to 0.100000 s" in message


def test_gap_in_the_positions(tmp_path: Path, write_bag, capsys) -> None:
    """A tenth of a second without positions is a hole, not a slow carriage."""
    bag = write_bag(
        tmp_path / "bag",
        a_run(),
        spoil=lambda topic, k, time, good: (
            None if topic == "/joint_states" and 200 <= k < 300 else (time, good)
        ),
    )
    assert "no position for 0.101 s after 0.199 s" in refused(bag, tmp_path, capsys)


def test_topics_recorded_at_different_times(tmp_path: Path, write_bag, capsys) -> None:
    """Pressures that begin an hour after the positions share no stretch with them."""
    bag = write_bag(
        tmp_path / "bag",
        a_run(),
        spoil=lambda topic, _, time, good: (
            time + 3600.0 if topic.endswith("pressure") else time,
            good,
        ),
    )
    assert "not recorded at the same time" in refused(bag, tmp_path, capsys)


def test_gauge_pressures(tmp_path: Path, write_bag, capsys) -> None:
    """Pressures that fall to zero are gauge readings: refused, not fitted."""
    run = a_run()
    gauge = MeasuredRun(**{**vars(run), "pressure_b": run.pressure_b - 4e5})
    message = refused(write_bag(tmp_path / "bag", gauge), tmp_path, capsys)
    assert "pressure_b falls to 0 Pa; absolute pressures are needed" in message


def test_run_that_says_nothing_of_friction(tmp_path: Path, write_bag, capsys) -> None:
    """A carriage at rest is a sound recording and no information: code 1, and no file."""
    run = a_run()
    resting = MeasuredRun(**{**vars(run), "position": np.full(len(run.time), 0.1)})
    bag, output = write_bag(tmp_path / "bag", resting), tmp_path / "found.yaml"
    code = identify.main(["friction", str(bag), "-o", str(output)], Quiet())
    assert code == 1
    assert "the carriage never moves" in capsys.readouterr().err
    assert not output.exists()


@pytest.mark.parametrize("subject", ["valve", "chambers"])
def test_run_that_says_nothing_of_the_chambers(
    tmp_path: Path, write_bag, capsys, subject: str
) -> None:
    """Pressures that stand still inform neither valve nor chambers: code 1, and no file."""
    bag, output = write_bag(tmp_path / "bag", a_run()), tmp_path / "found.yaml"
    assert identify.main([subject, str(bag), "-o", str(output)], Quiet()) == 1
    assert "the pressures change by only 20 Pa" in capsys.readouterr().err
    assert not output.exists()


SPOILT: dict[str, tuple[Callable[[int, float], float], str, str]] = {
    "mm": (
        lambda _, x: 1e3 * x,
        "/joint_states",
        "m, the stroke is 0.2 m; positions are in m",
    ),
    "a spike of the position": (
        lambda k, x: 5.0 if k == 7 else x,
        "/joint_states",
        "position: sample 7, at 0.007 s, is 5 m, the stroke is 0.2 m; positions are in m",
    ),
    "a spike of the pressure": (
        lambda k, p: 1e12 if k == 3 else p,
        "/chamber_a/pressure",
        "pressure_a: sample 3, at 0.003 s, is 1e+12 Pa, no rig has more than 2.4e+06 Pa",
    ),
    "a spike beyond all": (
        lambda k, p: 1e30 if k == 0 else p,
        "/chamber_b/pressure",
        "pressure_b: sample 0, at 0 s, is 1e+30 Pa",
    ),
    "kPa for Pa": (
        lambda _, p: 1e3 * p,
        "/supply/pressure",
        "supply_pressure: sample 0, at 0 s, is 6e+08 Pa, no rig has more",
    ),
}


@pytest.mark.parametrize("subject", ["friction", "chambers", "bristles", "spool"])
@pytest.mark.parametrize("kind", SPOILT)
def test_what_is_of_no_such_rig_is_refused(
    tmp_path: Path, write_bag, capsys, subject: str, kind: str
) -> None:
    """Other units, and readings that no rig can have: sample, value and bound are named."""
    spoil, where, said = SPOILT[kind]
    bag = write_bag(
        tmp_path / "bag",
        a_run(),
        spoil=lambda topic, k, time, good: (time, spoil(k, good) if topic == where else good),
    )
    message = refused(bag, tmp_path, capsys, subject)
    assert said in message
    assert message.count("\n") == 1


def test_what_a_rig_may_show_is_not_refused() -> None:
    """The highest supply with its noise, and friction of a rig whose zero is in mid-stroke."""
    run = a_run()
    high = replace(run, supply_pressure=run.supply_pressure * 2.0 + 1e3)
    check_run(high, RigParameters({"supply.pressure": 1.2e6}))
    middle = replace(run, position=run.position - 0.19)
    check_run(middle, RigParameters(), absolute=False)
    with pytest.raises(
        RunError, match=r"sample 0, at 0 s, is -0\.09 m, the stroke is 0\.2 m; .* A,"
    ):
        check_run(middle, RigParameters())


def test_a_run_shorter_than_what_is_looked_at(tmp_path: Path, write_bag, capsys) -> None:
    """0.2 s have no window of 0.25 s of uniform motion: code 1, no file; nor has a slow clock."""
    bag, output = write_bag(tmp_path / "bag", a_run(200)), tmp_path / "found.yaml"
    assert identify.main(["friction", str(bag), "-o", str(output)], Quiet()) == 1
    assert "0.2 s of samples, at least 0.25 s are needed" in capsys.readouterr().err
    assert not output.exists()
    slow = a_run(100)
    slow = replace(slow, time=slow.time * 100.0)
    message = refused(write_bag(tmp_path / "slow", slow), tmp_path, capsys)
    assert "a sample every 0.1 s refused, 5 in 0.25 s are needed" in message


def test_chambers_are_not_looked_for_between_samples_farther_apart_than_they_fill() -> None:
    """A sample a second, as where ms are taken for s: the fit went on for hours."""
    run = a_run(3000)
    with pytest.raises(RunError, match=r"^a sample every 1 s refused, .* to 0\.1 s;"):
        identify_chambers(replace(run, time=run.time * 1000.0), RigParameters())


def test_no_output_takes_the_place_of_what_is_read(tmp_path: Path, write_bag, capsys) -> None:
    """The description of a bag was replaced, and the bag lost; the base would be, too."""
    bag = write_bag(tmp_path / "bag", a_run())
    base = tmp_path / "base.yaml"
    base.write_text("plant:\n  ros__parameters:\n    supply.pressure: 6.0e5\n")
    link = tmp_path / "link.yaml"
    link.symlink_to(bag / "metadata.yaml")
    packed = bag / "bag_0.mcap.zstd"
    packed.write_bytes(b"packed")
    for output in (bag / "metadata.yaml", next(bag.glob("*.mcap")), link, packed, base):
        before = output.read_bytes()
        arguments = ["friction", str(bag), "-o", str(output), "--base", str(base)]
        assert identify.main(arguments, Quiet()) == 2
        said = "is read as --base" if output == base else "has the name of a file of a bag"
        line = f"{output}: cannot be written: it {said}; give another --output\n"
        assert capsys.readouterr().err == line
        assert output.read_bytes() == before


@pytest.mark.parametrize("name", ["own_0.mcap", "own_0.db3", "own_0.mcap.zstd", "metadata.yaml"])
def test_no_output_has_the_name_of_a_file_of_a_bag(
    tmp_path: Path, write_bag, capsys, name: str
) -> None:
    """Where no such file is yet, too: parameters in a bag's folder would pass for its messages."""
    bag = write_bag(tmp_path / "bag", a_run())
    output = bag / name
    output.unlink(missing_ok=True)
    before = sorted(bag.iterdir())
    assert identify.main(["friction", str(bag), "-o", str(output)], Quiet()) == 2
    assert capsys.readouterr().err == (
        f"{output}: cannot be written: it has the name of a file of a bag; give another --output\n"
    )
    assert sorted(bag.iterdir()) == before


@pytest.mark.parametrize("identify_it", [identify_chambers, identify_bristles, identify_friction])
@pytest.mark.parametrize("unit", [1e-300, 1e-6, 1e4, 1e200])
def test_a_run_on_another_clock(identify_it: Callable[..., object], unit: float) -> None:
    """Milliseconds, hours and nonsense in place of s: the period is named."""
    run = a_run()
    with pytest.raises(RunError, match=r"^a sample every .* s refused, .* 1e-06 to (0\.)?1 s;"):
        identify_it(replace(run, time=run.time * unit), RigParameters())


def test_unknown_base(tmp_path: Path, write_bag, capsys) -> None:
    """A base that is neither preset nor file is refused by name, once, and the bag is not."""
    bag, output = write_bag(tmp_path / "bag", a_run()), tmp_path / "found.yaml"
    arguments = ["valve", str(bag), "-o", str(output), "--base", "papre"]
    assert identify.main(arguments, Quiet()) == 2
    assert capsys.readouterr().err == (
        "papre: neither a preset (calibrated, paper) nor a file that can be read: "
        "No such file or directory\n"
    )
    assert not output.exists()


def test_a_base_of_another_rig(tmp_path: Path, write_bag, capsys) -> None:
    """What a file has for rigs of other namespaces is not taken as known for the bag's."""
    bag, base = write_bag(tmp_path / "bag", a_run()), tmp_path / "base.yaml"
    base.write_text("/left/plant: {ros__parameters: {supply.pressure: 600000.0}}\n")
    arguments = ["valve", str(bag), "-o", str(tmp_path / "found.yaml"), "--base", str(base)]
    for more, where in (([], "/"), (["--namespace", "/right"], "/right")):
        assert identify.main([*arguments, *more], Quiet()) == 2
        assert capsys.readouterr().err == (
            f"{base}: no section is for the plant or controller of namespace {where}; "
            "it has /left/plant\n"
        )


def sliding_run() -> MeasuredRun:
    """Forward at 5, 10 and 20 mm/s for 1 s each, friction 12 N + 4500 N·s/m on 4.9087e-4 m²."""
    speed = np.repeat([5e-3, 10e-3, 20e-3], 1000)
    time = np.arange(3000) * 1e-3
    level = np.full(3000, 4e5)
    push = (12.0 + 4500.0 * speed) / 4.908739e-4
    position = 0.05 + np.cumsum(speed) * 1e-3
    return MeasuredRun(time, position, level + push, level, level + 2e5, np.full(3000, 5.4))


def test_output_that_cannot_be_written(tmp_path: Path, write_bag, capsys) -> None:
    """Where a folder of the output's path is a file, that is said, with code 2."""
    (tmp_path / "blocked").write_text("")
    bag = write_bag(tmp_path / "bag", sliding_run())
    output = tmp_path / "blocked" / "found.yaml"
    arguments = ["friction", str(bag), "-o", str(output), "--sensors", "ideal"]
    assert identify.main(arguments, Quiet()) == 2
    assert f"{output}: cannot be written" in capsys.readouterr().err


def test_disk_that_fills_up(tmp_path: Path, write_bag, capsys, monkeypatch) -> None:
    """A file of an earlier run stays as it was when the new one cannot be finished."""
    bag, output = write_bag(tmp_path / "bag", sliding_run()), tmp_path / "out" / "found.yaml"
    output.parent.mkdir()
    output.write_text("earlier\n")

    fill_up(monkeypatch)
    arguments = ["friction", str(bag), "-o", str(output), "--sensors", "ideal"]
    assert identify.main(arguments, Quiet()) == 2
    assert "No space left on device" in capsys.readouterr().err
    assert output.read_text() == "earlier\n"
    assert list(output.parent.iterdir()) == [output]


def test_a_picture_takes_no_place_of_the_parameters(tmp_path: Path, capsys) -> None:
    """The residuals are drawn beside FILE.yaml, as FILE.png: an output of that name is refused."""
    output = tmp_path / "found.png"
    with pytest.raises(SystemExit) as ended:
        identify.main(["friction", "bag", "-o", str(output)], Quiet())
    assert ended.value.code == 2
    assert f"the residuals are drawn in '{output}'; end it in .yaml" in capsys.readouterr().err
    assert not output.exists()


def test_a_picture_that_cannot_be_written(tmp_path: Path, write_bag, capsys) -> None:
    """Is found before the work, and named itself."""
    bag, picture = write_bag(tmp_path / "bag", sliding_run()), tmp_path / "found.png"
    picture.mkdir()
    assert identify.main(["friction", str(bag), "-o", str(tmp_path / "found.yaml")], Quiet()) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line == f"{picture}: cannot be written: Is a directory"
    assert not (tmp_path / "found.yaml").exists()


def test_a_disk_that_fills_up_between_parameters_and_picture(
    tmp_path: Path, write_bag, capsys, monkeypatch
) -> None:
    """What was found is printed all the same; the parameters and picture of before stay a pair."""
    bag, output = write_bag(tmp_path / "bag", sliding_run()), tmp_path / "out" / "found.yaml"
    output.parent.mkdir()
    earlier = {output: b"earlier\n", output.with_suffix(".png"): b"earlier picture"}
    for file, content in earlier.items():
        file.write_bytes(content)

    fill_up(monkeypatch, room=1)
    arguments = ["friction", str(bag), "-o", str(output), "--sensors", "ideal"]
    assert identify.main(arguments, Quiet()) == 2
    said = capsys.readouterr()
    assert "friction.forward.viscous" in said.out
    assert "the residuals are what the stated sensors explain" in said.out + said.err
    assert "written to" not in said.out
    assert said.err.splitlines()[-1].endswith("cannot be written: No space left on device")
    assert {file: file.read_bytes() for file in output.parent.iterdir()} == earlier


def test_compare_refuses_the_same_bags(tmp_path: Path, write_bag, capsys) -> None:
    """`rodless compare` reads bags the same way: NaN is named, nothing is drawn."""
    bag = write_bag(
        tmp_path / "bag",
        a_run(),
        spoil=lambda _, k, time, good: (time, math.nan if k == 7 else good),
    )
    output = tmp_path / "compared"
    assert compare.main(["paper", str(bag), "--output", str(output)], Quiet()) == 2
    assert "/joint_states: message 7" in capsys.readouterr().err
    assert not output.exists()
