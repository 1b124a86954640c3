# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Commands carry no stamp: which sample each answers, and when the valve followed, from a bag."""

import json
from collections.abc import Collection, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
import rig_bag
from builtin_interfaces.msg import Time
from quiet_stop import Quiet
from rclpy.serialization import serialize_message
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from rodless_base.constants import CLOSED_VOLTAGE, SUPPLY_PRESSURE
from rodless_control import PidParameters, references
from rodless_lab import closed_loop
from rodless_lab.bags.metadata import BagTopic
from rodless_lab.bags.writer import BagWriter
from rodless_lab.cli import compare, identify
from rodless_lab.cli import replay as replay_command
from rodless_lab.runs.commands import summary
from rodless_lab.runs.from_bag import read_commands, read_run
from rodless_lab.runs.measured_run import MeasuredRun, RunError, run_of_trace
from rodless_lab.runs.resimulate import replay
from rodless_sim import RigParameters, simulate

Array = npt.NDArray[np.float64]

PAPER = RigParameters.preset("paper")
PERIOD = 1e-3

# When the recording began by the wall clock (s).
WALL = 1000.0

# What a replay may depart from the recording (m).
EXACT = 5e-5


@pytest.fixture(scope="module")
def step() -> MeasuredRun:
    """A step of section 6.2, 1.5 s of it."""
    trace = closed_loop(
        PAPER, PidParameters.preset("paper"), references.step(0.0, 0.058, at=0.1), 1.5, PERIOD
    )
    return run_of_trace(trace, SUPPLY_PRESSURE)


def write(
    path: Path,
    run: MeasuredRun,
    sent: Array,
    answers: tuple[Array, Array],
    held: bool = False,
    late: Array | None = None,
    lost: Mapping[str, Collection[int]] | None = None,
) -> Path:
    """Write a bag whose samples were sent at ``sent`` (s), and commands ``answers`` (s, V).

    ``held`` adds what the valve held. The recorder logs each sample ``late`` (s) after its sending,
    and loses the samples ``lost`` of a topic.
    """
    lost = lost or {}
    topics = {"/joint_states": "JointState", **dict.fromkeys(rig_bag.PRESSURES, "FluidPressure")}
    logged = sent + (0.0 if late is None else late)
    with BagWriter(path) as writer:
        for topic, kind in {**topics, "/valve/state": "JointState"}.items():
            writer.add_topic(BagTopic(topic, f"sensor_msgs/msg/{kind}"))
        writer.add_topic(BagTopic("/valve/voltage", "std_msgs/msg/Float64"))
        values = {topic: getattr(run, name) for topic, name in rig_bag.PRESSURES.items()}
        values["/joint_states"] = run.position
        for k, (stamp, log, publish) in enumerate(zip(run.time, logged, sent, strict=True)):
            times = round(log * 1e9), round(publish * 1e9)
            for topic in topics:
                if k not in lost.get(topic, ()):
                    value = float(values[topic][k])
                    writer.write(topic, rig_bag.payload(topic, stamp, value), *times)
            if held and k not in lost.get("/valve/state", ()):
                volts = run.voltage[k - 1] if k else CLOSED_VOLTAGE
                writer.write("/valve/state", valve_state(stamp, float(volts)), *times)
        for when, volts in zip(*answers, strict=True):
            time = round(when * 1e9)
            writer.write(
                "/valve/voltage", rig_bag.payload("/valve/voltage", 0.0, volts), time, time
            )
    return path


def valve_state(stamp: float, voltage: float) -> bytes:
    seconds, nanoseconds = divmod(round(stamp * 1e9), 10**9)
    header = Header(stamp=Time(sec=seconds, nanosec=nanoseconds))
    return serialize_message(
        JointState(header=header, name=["valve_spool"], position=[0.0], effort=[voltage])
    )


def departure(bag: Path) -> float:
    """How far (m) a replay departs from what is in the bag."""
    recorded = read_run(bag)
    assert np.ptp(recorded.position) > 0.05
    return float(np.abs(replay(PAPER, recorded).position - recorded.position).max())


@pytest.mark.parametrize("speed", [0.5, 1.0, 3.0])
def test_commands_in_wall_time_are_dated_by_the_samples_beside_them(
    tmp_path: Path, step: MeasuredRun, speed: float
) -> None:
    """A bag without what the valve held, at any speed of plant time, each answer 0.2 ms late."""
    sent = WALL + step.time / speed
    bag = write(tmp_path / "bag", step, sent, (sent + 2e-4, step.voltage))
    assert departure(bag) < EXACT


def test_a_plant_that_lags_now_and_then_is_followed(tmp_path: Path, step: MeasuredRun) -> None:
    """On a crowded machine samples come late, up to 20 ms; their answers follow them."""
    generator = np.random.default_rng(3)
    pauses = np.where(generator.random(len(step.time)) < 0.1, generator.uniform(0, 0.02), 0.0)
    sent = WALL + step.time + np.cumsum(pauses)
    bag = write(tmp_path / "bag", step, sent, (sent + 3e-4, step.voltage))
    assert departure(bag) < EXACT


def test_a_recorder_that_lags_shifts_nothing(tmp_path: Path, step: MeasuredRun) -> None:
    """Log times in bunches do not matter where the senders' times are in the bag."""
    sent = WALL + step.time
    late = np.ceil(step.time / 0.02) * 0.02 - step.time
    bag = write(tmp_path / "bag", step, sent, (sent + 3e-4, step.voltage), late=late)
    assert departure(bag) < EXACT


@pytest.mark.slow
@pytest.mark.parametrize("wall", [0.0, WALL])
def test_answers_out_of_step_are_not_replayed_on_trust(
    tmp_path: Path, step: MeasuredRun, capsys: pytest.CaptureFixture[str], wall: float
) -> None:
    """On a loaded machine answers come after the next sample: when they acted is not in the bag.

    In wall time and in plant time alike. Nothing is written; a bag that says what the valve held
    replays, however late the answers came.
    """
    generator = np.random.default_rng(4)
    late = generator.exponential(7e-4, len(step.time))
    sent = wall + step.time
    commanded = np.maximum.accumulate(sent + late)
    if not wall:  # a command has the time of the sample before it
        commanded = np.floor(commanded / PERIOD + 1e-9) * PERIOD
    old = write(tmp_path / "old", step, sent, (commanded, step.voltage))
    output = tmp_path / "out"
    said = r"do not answer one sample each, so it is not known when the valve took them; record"
    for command in (replay_command, compare):
        first = ["paper"] if command is compare else []
        assert command.main([*first, str(old), "--output", str(output)], Quiet()) == 2
        error = capsys.readouterr().err
        assert said in error
        assert error.count("\n") == 1
        assert not output.exists()
    new = write(tmp_path / "new", step, sent, (commanded, step.voltage), held=True)
    assert departure(new) < 1e-9


@pytest.mark.slow
def test_what_does_not_simulate_the_voltage_goes_on_and_says_so(
    tmp_path: Path, step: MeasuredRun, capsys: pytest.CaptureFixture[str]
) -> None:
    """Friction is identified and two bags are compared; a line says what to make of the voltage."""
    sent = WALL + step.time
    commanded = np.maximum.accumulate(sent + np.where(np.arange(len(sent)) % 20, 3e-4, 1.3e-3))
    bag = write(tmp_path / "bag", step, sent, (commanded, step.voltage))
    assert compare.main([str(bag), str(bag), "--output", str(tmp_path / "out")], Quiet()) == 0
    assert "bag: /valve/voltage: 149 of 1501 commands do not" in capsys.readouterr().err
    arguments = ["friction", str(bag), "-o", str(tmp_path / "friction.yaml")]
    code = identify.main(arguments, Quiet())
    if code == 0:
        assert "do not answer one sample each" in capsys.readouterr().err
    assert code in (0, 1)


def test_commands_that_end_too_early_are_in_doubt(tmp_path: Path, step: MeasuredRun) -> None:
    """The plant closes its valve some time after the last command; an old bag does not say when."""
    sent = step.time
    bag = write(tmp_path / "bag", step, sent, (sent[:800], step.voltage[:800]))
    with pytest.raises(RunError, match="701 samples have no command, for which the valve may cl"):
        replay(PAPER, read_run(bag))


def test_few_commands_by_hand_are_taken_as_they_come(tmp_path: Path) -> None:
    """Three voltages in 1.2 s: each acts from the sample before it on."""
    run = run_of_trace(simulate(PAPER, np.repeat([5.6, 4.7, 5.3], 400), PERIOD, 0.08), 6e5)
    run = replace(run, supply_pressure=np.full(len(run.time), SUPPLY_PRESSURE))
    sent = WALL + 2.0 * run.time
    commanded = WALL + 2.0 * np.array([0.0003, 0.4003, 0.8003])
    bag = write(tmp_path / "bag", run, sent, (commanded, np.array([5.6, 4.7, 5.3])))
    recorded = read_run(bag)
    assert recorded.doubt == ""
    assert np.abs(replay(PAPER, recorded).position - recorded.position).max() < EXACT


def test_samples_in_bunches_put_even_few_commands_in_doubt(
    tmp_path: Path, step: MeasuredRun
) -> None:
    """Twenty samples that a recorder took at once: a command among them answers any."""
    sent = WALL + np.floor(step.time / 0.02) * 0.02
    commanded = sent[::100] + 1e-4
    bag = write(tmp_path / "bag", step, sent, (commanded, step.voltage[::100]))
    assert "samples were recorded in bunches" in read_run(bag).doubt


def test_the_bag_tells_latency_and_the_sample_answered(tmp_path: Path, step: MeasuredRun) -> None:
    """Answers 0.4 ms after their samples at half speed; the valve takes them one sample late."""
    sent = WALL + 2.0 * step.time
    delayed = np.append(step.voltage[1:], step.voltage[-1])
    bag = write(tmp_path / "bag", step, sent, (sent + 4e-4, delayed), held=True)
    commands = read_commands(bag)
    np.testing.assert_array_equal(commands.sample, np.arange(len(step.time)))
    np.testing.assert_allclose(commands.time, step.time, atol=1e-9)
    np.testing.assert_allclose(commands.latency, 4e-4, atol=1e-8)
    assert summary(commands, PERIOD).endswith("sent 0.40 ms after it (99 %: 0.40 ms)")
    # What answers the last sample acts on nothing in the bag.
    changing = np.flatnonzero(np.diff(step.voltage))[:-1]
    assert len(changing) > 300
    late = commands.held_from - commands.time
    np.testing.assert_allclose(late[changing], PERIOD, atol=1e-9)
    assert list(commands.units().values()) == ["s", "V", "", "s", "s"]


def test_a_command_that_another_overtook_was_never_held(tmp_path: Path, step: MeasuredRun) -> None:
    """Two answers to one sample: the second counts. Beyond 10 V the valve holds 10 V."""
    run = replace(step, voltage=np.full(len(step.time), 10.0))
    sent = WALL + step.time
    commanded = sent[[5, 5, 7, 9]] + np.array([1e-4, 2e-4, 1e-4, 1e-4])
    volts = np.array([3.0, 12.0, np.nan, 10.0])
    bag = write(tmp_path / "bag", run, sent, (commanded, volts), held=True)
    commands = read_commands(bag)
    assert commands.sample.tolist() == [5, 5, 7, 9]
    np.testing.assert_allclose(commands.held_from, [np.nan, run.time[5], np.nan, run.time[9]])
    assert summary(commands, PERIOD).startswith(
        "4 commands, 2 held from the sample that they answer on, 2 never"
    )


def test_before_the_first_sample_nothing_is_answered(tmp_path: Path, step: MeasuredRun) -> None:
    """A command sent before the recording's first sample is in force at it, and has no latency."""
    sent = WALL + 2.0 * step.time
    bag = write(tmp_path / "bag", step, sent, (sent[:1] - 0.5, np.array([5.5])))
    commands = read_commands(bag)
    assert commands.sample.tolist() == [-1]
    assert commands.time == pytest.approx([-0.25], rel=1e-3)
    assert np.isnan(commands.latency).all()
    assert (read_run(bag).voltage == 5.5).all()
    assert "when the valve followed them was not recorded" in summary(commands, PERIOD)


@pytest.mark.slow
def test_the_command_says_how_the_commands_came(
    tmp_path: Path, step: MeasuredRun, capsys: pytest.CaptureFixture[str]
) -> None:
    """`rodless replay` prints it below the differences."""
    bag = write(tmp_path / "bag", step, step.time, (step.time, step.voltage), held=True)
    assert replay_command.main([str(bag), "--output", str(tmp_path / "out")], Quiet()) == 0
    assert (
        "1501 commands, 1500 held from the sample that they answer on\n" in capsys.readouterr().out
    )


@pytest.mark.slow
def test_samples_that_the_recorder_lost_are_counted(
    tmp_path: Path, step: MeasuredRun, capsys: pytest.CaptureFixture[str]
) -> None:
    """Ten of the valve's and one position are missing: each command that reads the bag says so."""
    lost = {"/joint_states": {700}, "/valve/state": {120, *range(130, 139)}}
    answers = step.time, step.voltage
    bag = write(tmp_path / "bag", step, step.time, answers, held=True, lost=lost)
    line = (
        f"{bag}: samples are missing, from 0.119 s on: 1 of 1501 of /joint_states, 10 of 1501 of "
        "/valve/state; a replay departs where the valve's were lost; record with"
    )
    for command, first in ((replay_command, []), (compare, ["paper"]), (compare, [str(bag)])):
        output = ["--output", str(tmp_path / "out")]
        assert command.main([*first, str(bag), *output], Quiet()) == 0
        error = capsys.readouterr().err
        assert error.startswith(line)
        assert error.count("\n") == 1
    whole = write(tmp_path / "whole", step, step.time, answers, held=True)
    assert read_run(whole).notes == ()
    assert departure(bag) > 2.0 * departure(whole)


@pytest.mark.slow
@pytest.mark.parametrize("topic", ["/joint_states", "/chamber_a/pressure", "/valve/state"])
def test_a_topic_that_ends_early_is_told(
    tmp_path: Path, step: MeasuredRun, capsys: pytest.CaptureFixture[str], topic: str
) -> None:
    """The run is as long as all are there, but for the valve's; the line says what it lacks.

    How many commands it holds is said too.
    """
    answers = step.time, step.voltage
    lost = {topic: range(701, 1501)}
    bag = write(tmp_path / "bag", step, step.time, answers, held=True, lost=lost)
    run = read_run(bag)
    line = f"from 0.700 s on: 800 of 1501 of {topic}, which ends 0.800 s early; "
    line += "a replay departs" if topic == "/valve/state" else "record with"
    assert run.missing.startswith(f"{bag}: samples are missing, {line}")
    assert replay_command.main([str(bag), "--output", str(tmp_path / "out")], Quiet()) == 0
    shown = capsys.readouterr()
    assert line in shown.err
    used = "1501 commands, " if topic == "/valve/state" else "701 of 1501 commands lie in the run, "
    assert f"\n{used}" in shown.out
    ragged = {name: range(1460, 1501) for name in lost}
    whole = write(tmp_path / "whole", step, step.time, answers, held=True, lost=ragged)
    assert read_run(whole).notes == ()


def test_commands_of_a_stretch_are_those_in_force_in_it(tmp_path: Path, step: MeasuredRun) -> None:
    """The one sent last before it, too; not those that it does not last until."""
    answers = np.array([0.1, 0.2, 0.3, 0.4]), np.array([5.0, 6.0, 7.0, 8.0])
    commands = read_commands(write(tmp_path / "bag", step, step.time, answers))
    for begin, end, volts in (
        (0.25, 0.35, [6.0, 7.0]),
        (0.2, 0.3, [6.0, 7.0]),
        (0.0, 9.0, [5.0, 6.0, 7.0, 8.0]),
        (0.5, 0.6, [8.0]),
        (0.0, 0.05, []),
    ):
        assert commands.during(begin, end).voltage.tolist() == volts
    none = summary(commands.during(0.0, 0.05), PERIOD, recorded=4)
    assert none.startswith("0 of 4 commands lie in the run")


@pytest.mark.parametrize("clock", [0.0, 1e-9, 2e-4], ids=["zero", "a count", "five times"])
def test_times_that_tell_no_samples_apart_date_no_command(
    tmp_path: Path, step: MeasuredRun, clock: float
) -> None:
    """A recorder that logs all messages at zero, by their number, or at a handful of times."""
    places = np.arange(len(step.time))
    sent = clock * (places if clock < 1e-6 else places // 300)
    old = write(tmp_path / "old", step, sent, (sent, step.voltage))
    said = "1501 samples share 6 log times" if clock > 1e-6 else "1501 samples share 1 log time"
    if clock:  # publication times were written too, which are the senders'
        said = said.replace("log", "publication")
    with pytest.raises(RunError, match=f"/valve/voltage: {said}, so it is not known when the val"):
        replay(PAPER, read_run(old))
    new = write(tmp_path / "new", step, sent, (sent, step.voltage), held=True)
    assert read_run(new).notes == ()
    assert departure(new) < 1e-9
    with pytest.raises(RunError, match=f"{said}, so it is not known which one each command answ"):
        read_commands(new)


def test_a_run_begins_where_the_valve_is_known(tmp_path: Path, step: MeasuredRun) -> None:
    """A recorder that heard of the valve three samples late has the run from there on."""
    written = rig_bag.write(tmp_path / "bag", step)
    assert len(read_run(written).time) == 1501
    cut = tmp_path / "cut"
    with BagWriter(cut) as writer:
        for topic, kind in (
            ("/joint_states", "sensor_msgs/msg/JointState"),
            *((topic, "sensor_msgs/msg/FluidPressure") for topic in rig_bag.PRESSURES),
            ("/valve/state", "sensor_msgs/msg/JointState"),
        ):
            writer.add_topic(BagTopic(topic, kind))
        for k, time in enumerate(step.time):
            log = round(time * 1e9)
            writer.write(
                "/joint_states", rig_bag.payload("/joint_states", time, step.position[k]), log, log
            )
            for topic, name in rig_bag.PRESSURES.items():
                value = float(getattr(step, name)[k])
                writer.write(topic, rig_bag.payload(topic, time, value), log, log)
            if k >= 3:
                volts = float(step.voltage[k - 1])
                writer.write("/valve/state", valve_state(time, volts), log, log)
    run = read_run(cut)
    assert len(run.time) == 1498
    np.testing.assert_allclose(run.position, step.position[3:], atol=1e-15)
    np.testing.assert_array_equal(run.voltage[:-1], step.voltage[3:-1])


def test_a_bag_of_what_the_valve_held_is_replayed_without_commands(
    tmp_path: Path, step: MeasuredRun, capsys: pytest.CaptureFixture[str]
) -> None:
    """The run is repeated all the same; a line says that nothing is known of the commands."""
    none = np.empty(0)
    bag = write(tmp_path / "bag", step, WALL + step.time, (none, none), held=True)
    output = tmp_path / "replay"
    assert replay_command.main([str(bag), "--output", str(output)], Quiet()) == 0
    assert "/valve/voltage holds no message" in capsys.readouterr().err
    written = json.loads((output / "replay.json").read_text(encoding="utf-8"))
    assert written["position"]["largest"] < EXACT
