# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Sound bags of what no simulated rig can do: one line that names bag and cause, exit code 2."""

from dataclasses import replace as replaced
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from quiet_stop import Quiet
from rcl_interfaces.msg import Parameter, ParameterEvent
from rclpy.serialization import serialize_message
from rig_bag import Spoil, untouched, with_arrays, write
from std_msgs.msg import Float64MultiArray

from rodless_lab.bags.metadata import BagError, BagTopic
from rodless_lab.bags.reader import read_bag
from rodless_lab.bags.writer import BagWriter
from rodless_lab.cli import animate, compare, replay
from rodless_lab.runs.from_bag import read_commands, read_run, read_run_and_setpoint
from rodless_lab.runs.measured_run import MeasuredRun, RunError, run_of_trace
from rodless_sim import RigParameters, simulate


@pytest.fixture
def run() -> MeasuredRun:
    """Return 0.1 s of a rig at rest and of one that begins to move."""
    voltages = np.r_[np.full(50, 5.0), np.full(50, 6.0)]
    return run_of_trace(simulate(RigParameters(), voltages, 1e-3, 0.1), 6e5)


def refused(verb, bag: Path, capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """Return the one line a verb says with code 2 of the bag, which it names."""
    preset = ["paper"] if verb is compare else []
    output = ["--output", str(bag.parent / "out.gif")]
    capsys.readouterr()
    assert verb.main([*preset, str(bag), *output, *arguments], Quiet()) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert str(bag) in said
    return said


def reading(topic: str, value: float, at: int | None = None) -> Spoil:
    """Put ``value`` in place of what ``topic`` has, in sample ``at`` or in all."""

    def put(here: str, sample: int, time: float, good: float) -> tuple[float, float]:
        return time, value if here == topic and at in (None, sample) else good

    return put


@pytest.mark.parametrize("pressure", [0.0, -1e5])
def test_a_chamber_without_air_is_not_replayed(
    tmp_path: Path, run: MeasuredRun, capsys: pytest.CaptureFixture[str], pressure: float
) -> None:
    """A gauge reading of a vented chamber: the rig's own words, and which bag has it."""
    bag = write(tmp_path / "bag", run, reading("/chamber_a/pressure", pressure))
    said = refused(replay, bag, capsys)
    assert f"no simulated rig can repeat it: pressures {pressure:g}" in said
    assert "must be finite and positive" in said


def test_a_supply_that_no_rig_has_is_not_replayed(
    tmp_path: Path, run: MeasuredRun, capsys: pytest.CaptureFixture[str]
) -> None:
    """A rig without air, or a gauge reading of one."""
    bag = write(tmp_path / "bag", run, reading("/supply/pressure", 0.0))
    for verb in (replay, compare):
        said = refused(verb, bag, capsys)
        assert "no simulated rig can repeat it: supply.pressure: 0.0 refused" in said


def test_set_points_in_mm_are_not_followed(
    tmp_path: Path, run: MeasuredRun, capsys: pytest.CaptureFixture[str]
) -> None:
    """58 m from a controller that counts in mm."""
    bag = write(tmp_path / "bag", run, setpoint=(0.01, 58.0))
    said = refused(compare, bag, capsys, "--drive", "setpoint")
    assert "the reference asks for 58 m" in said


def test_samples_too_far_apart_are_not_replayed(
    tmp_path: Path, run: MeasuredRun, capsys: pytest.CaptureFixture[str]
) -> None:
    """A clock in the wrong unit."""

    def rarely(_topic: str, _sample: int, time: float, value: float) -> tuple[float, float]:
        return 1e10 * time, value

    bag = write(tmp_path / "bag", run, rarely, held=True)
    for verb in (replay, compare):
        assert "no simulated rig can repeat it: period 1000" in refused(verb, bag, capsys)


@pytest.mark.parametrize("verb", [replay, compare, animate])
@pytest.mark.parametrize(
    "topic", ["/joint_states", "/valve/state", "/supply/pressure", "/chamber_b/pressure"]
)
def test_a_reading_of_no_instrument_is_named(
    tmp_path: Path, run: MeasuredRun, capsys: pytest.CaptureFixture[str], topic: str, verb
) -> None:
    """1e308 is finite, and nothing can be computed or drawn from it."""
    bag = write(tmp_path / "bag", run, reading(topic, 1e308, at=7), held=True)
    said = refused(verb, bag, capsys)
    assert f"{topic}: message 7, at 0.007" in said
    assert "holds 1e+308, must be a number within ±1e+100" in said


def test_a_replay_that_has_to_start_elsewhere_says_so(
    tmp_path: Path, run: MeasuredRun, capsys: pytest.CaptureFixture[str]
) -> None:
    """At the end of a stroke that the recorded cylinder has passed; at its own place, nothing."""

    def farther(topic: str, _sample: int, time: float, value: float) -> tuple[float, float]:
        return time, value + (0.4 if topic == "/joint_states" else 0.0)

    for name, spoil in (("near", None), ("far", farther)):
        bag = write(tmp_path / name, run, *filter(None, [spoil]), held=True)
        assert replay.main([str(bag), "--output", str(tmp_path / "out")], Quiet()) == 0
        said = capsys.readouterr().err
        line = "starts at 200 mm, the end of its stroke, the recorded one at 500 mm: the rig may"
        assert (line in said) == (name == "far")


@pytest.mark.parametrize("numbers", [[[1.0, 2.0]] * 20, [[]] * 20, [[1.0], [1.0, 2.0]] * 10])
def test_arrays_are_no_set_points_and_no_voltages(
    tmp_path: Path, run: MeasuredRun, numbers: list[list[float]]
) -> None:
    """They were flattened, and drawn one behind the other."""
    bag = with_arrays(tmp_path, run, "/setpoint", numbers)
    with pytest.raises(RunError, match="/setpoint: std_msgs/msg/Float64MultiArray has no data of"):
        read_run_and_setpoint(bag)
    (tmp_path / "voltage").mkdir()
    bag = with_arrays(tmp_path / "voltage", run, "/valve/voltage", numbers)
    with pytest.raises(RunError, match=r"/valve/voltage: .* has no data of one number"):
        read_commands(bag)


def test_one_long_array_among_short_ones_makes_no_table(tmp_path: Path, run: MeasuredRun) -> None:
    """100 messages, one of a million numbers: a table of them would be 100 times that."""
    numbers = [[0.0]] * 99 + [np.zeros(1_000_000).tolist()]
    found = read_bag(with_arrays(tmp_path, run, "/many", numbers))["/many"]
    assert len(found.messages[-1].data) == 1_000_000
    with pytest.raises(BagError, match="array of up to 1000000 numbers in 100 messages"):
        _ = found.fields["data"]
    assert found.fields["layout.data_offset"].shape == (100,)


def test_a_table_of_too_many_columns_is_not_saved(tmp_path: Path, run: MeasuredRun) -> None:
    """As an array it is there."""
    numbers = [np.zeros(20_000).tolist()] * 20
    found = read_bag(with_arrays(tmp_path, run, "/many", numbers))["/many"]
    assert found.fields["data"].shape == (20, 20_000)
    with pytest.raises(BagError, match="20000 numbers, too many for columns"):
        found.save(tmp_path / "many.csv")


def test_a_topic_that_lacks_is_told_without_the_names_of_all(tmp_path: Path) -> None:
    """Some of those that there are, and how many more."""
    bag = tmp_path / "bag"
    with BagWriter(bag) as writer:
        for k in range(300):
            writer.add_topic(BagTopic(f"/topic{k}", "std_msgs/msg/Float64"))
        writer.write("/topic0", serialize_message(Float64MultiArray()), 0, 0)
    with pytest.raises(RunError, match=r"/topic19 and 280 more$"):
        read_run(bag)


@pytest.mark.parametrize("namespace", [None, 5])
def test_what_is_no_namespace_is_refused(tmp_path: Path, namespace: object) -> None:
    """As the wrong type, by its value."""
    for read in (read_run, read_commands):
        with pytest.raises(TypeError, match=f"{namespace} refused, must be a namespace"):
            read(tmp_path, namespace)  # type: ignore[operator]


def test_a_set_point_that_no_controller_takes_spoils_no_run(
    tmp_path: Path, run: MeasuredRun
) -> None:
    """Somebody has sent NaN: the controller has refused it, and the run went on without."""
    bag = write(tmp_path / "bag", run, setpoint=(0.03, np.nan))
    found, setpoint = read_run_and_setpoint(bag)
    assert setpoint is None
    assert found.notes == (
        f"{bag}: /setpoint: 1 of 1 set-points are no number within ±1e100 m and left out",
    )
    good, setpoint = read_run_and_setpoint(write(tmp_path / "good", run, setpoint=(0.03, 0.1)))
    assert setpoint is not None
    assert setpoint.position.tolist() == [0.1]
    assert good.notes == ()


def test_voltages_between_the_samples_are_told_of(tmp_path: Path) -> None:
    """A position sensor that is slower than the valve's driver: the replay cannot have all."""
    voltages = 5.0 + np.sin(0.1 * np.arange(200))
    run = run_of_trace(simulate(RigParameters(), voltages, 1e-3, 0.1), 6e5)

    def thinned(topic: str, sample: int, time: float, value: float) -> tuple[float, float] | None:
        return (time, value) if sample % 10 == 0 or topic != "/joint_states" else None

    whole, thin = (
        read_run(write(tmp_path / name, run, spoil, held=True))
        for name, spoil in (("whole", untouched), ("thin", thinned))
    )
    assert whole.notes == ()
    (note,) = thin.notes
    # 20 spans of ten voltages each, of which the first is kept; the last of all is kept, too.
    assert f"{20 * 9 - 1} voltages of valve/state lie between the samples of /joint_states" in note
    assert "which come every 10 ms, and are left out; a replay departs" in note


@pytest.mark.parametrize("late", [4e-4, -4e-4])
def test_voltages_with_stamps_of_their_own_are_not_missed(tmp_path: Path, late: float) -> None:
    """A driver that stamps beside the sensor's samples, as often: each voltage has its sample."""
    voltages = 5.0 + np.sin(0.1 * np.arange(200))
    run = run_of_trace(simulate(RigParameters(), voltages, 1e-3, 0.1), 6e5)

    def beside(topic: str, _: int, time: float, value: float) -> tuple[float, float]:
        return (time + 1e-3 + late if topic == "/valve/state" else time + 1e-3), value

    assert read_run(write(tmp_path / "bag", run, beside, held=True)).notes == ()


def test_voltages_that_jitter_are_told_of_as_such(tmp_path: Path) -> None:
    """As many as there are positions, and some of them two to one: more positions do not help."""
    voltages = 5.0 + np.sin(0.1 * np.arange(200))
    run = run_of_trace(simulate(RigParameters(), voltages, 1e-3, 0.1), 6e5)
    jitter = np.random.default_rng(1).uniform(-2e-5, 2e-5, 201)

    def jittering(topic: str, sample: int, time: float, value: float) -> tuple[float, float]:
        return (time + 1e-3 + jitter[sample] if topic == "/valve/state" else time + 1e-3), value

    notes = "".join(read_run(write(tmp_path / "bag", run, jittering, held=True)).notes)
    assert "voltages of /valve/state lie between" in notes.replace("of valve", "of /valve")
    assert "give both the same stamps" in notes
    assert "as often" not in notes


def test_a_voltage_that_is_held_is_not_missed(tmp_path: Path, run: MeasuredRun) -> None:
    """Between the samples nothing has changed: nothing is left out."""

    def thinned(topic: str, sample: int, time: float, value: float) -> tuple[float, float] | None:
        return (time, value) if sample % 5 == 0 or topic != "/joint_states" else None

    assert read_run(write(tmp_path / "bag", run, thinned, held=True)).notes == ()


@pytest.mark.parametrize("unstamped", ["/chamber_a/pressure", "/joint_states"])
def test_a_topic_without_stamps_beside_others_is_told_of(
    tmp_path: Path, run: MeasuredRun, unstamped: str
) -> None:
    """It is dated by when it was recorded, the others by when they were."""
    bag = write(tmp_path / "bag", run)
    plain = read_bag(bag)
    with BagWriter(tmp_path / "unstamped") as writer:
        for name in plain:
            writer.add_topic(plain[name].topic)
            for when, message in zip(plain[name].log_time, plain[name].messages, strict=True):
                if name == unstamped:
                    message.header.stamp.sec = message.header.stamp.nanosec = 0
                writer.write(name, serialize_message(message), int(when), int(when))
    (note,) = read_run(tmp_path / "unstamped").notes
    assert note.startswith(f"{tmp_path / 'unstamped'}: {unstamped}: without stamps, dated by")
    assert read_run(bag).notes == ()


def test_what_is_shown_only_is_no_rig(tmp_path: Path, run: MeasuredRun) -> None:
    """The plant publishes throttled positions for whoever looks on, below a name of their own."""
    plain = read_bag(write(tmp_path / "plain", run))
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic(replaced(plain["/joint_states"].topic, name="/_throttled/joint_states"))
        writer.write("/_throttled/joint_states", plain["/joint_states"].payloads[0], 0, 0)
    with pytest.raises(RunError, match="/joint_states was not recorded; the bag holds /_throttled"):
        read_run(tmp_path / "bag")


def test_a_rig_in_another_namespace_is_named(
    tmp_path: Path, run: MeasuredRun, capsys: pytest.CaptureFixture[str]
) -> None:
    """With the word that finds it."""
    plain = read_bag(write(tmp_path / "plain", run))
    with BagWriter(tmp_path / "bag") as writer:
        for name in plain:
            writer.add_topic(replaced(plain[name].topic, name=f"/left{name}"))
            for when, data in zip(plain[name].log_time, plain[name].payloads, strict=True):
                writer.write(f"/left{name}", data, int(when), int(when))
    said = refused(replay, tmp_path / "bag", capsys)
    assert "joint_states was recorded of a rig in /left; give that as the namespace" in said
    assert len(read_run(tmp_path / "bag", "/left").time) == len(run.time)


def jumping(topic: str, sample: int, time: float, value: float) -> tuple[float, float]:
    """Let every second sample be that of another plant, 40 mm away."""
    return time, value + (0.04 * (sample % 2) if topic == "/joint_states" else 0.0)


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (untouched, ""),
        (jumping, "/joint_states: the position jumps by 0.04 m within 0.001 s, at 0.001 s"),
        (reading("/valve/state", 5000.0, at=60), "voltages leave 0 to 10 V, at 0.059 s with 5000"),
        (reading("/valve/state", -0.05), ""),
    ],
    ids=["sound", "two plants", "mV", "a converter"],
)
def test_what_no_rig_does_is_told(
    tmp_path: Path, run: MeasuredRun, spoil: Spoil, said: str
) -> None:
    """The run is read all the same, with a line that says what is odd, and since when."""
    found = read_run(write(tmp_path / "bag", run, spoil, held=True))
    assert bool(found.remarks) == bool(said)
    assert said in "".join(found.remarks)


def test_a_topic_of_few_samples_is_told(tmp_path: Path, run: MeasuredRun) -> None:
    """Three pressures beside a hundred positions; one in ten is a slow instrument, and no word."""

    def every(step: int) -> Spoil:
        def some(topic: str, sample: int, time: float, value: float) -> tuple[float, float] | None:
            return None if topic == "/supply/pressure" and sample % step else (time, value)

        return some

    few = read_run(write(tmp_path / "few", run, every(50)))
    assert "3 samples of /supply/pressure beside 101 of /joint_states" in "".join(few.remarks)
    assert not read_run(write(tmp_path / "some", run, every(10))).remarks


@pytest.mark.parametrize("count", [1, 2])
def test_several_publishers_of_a_topic_are_told(
    tmp_path: Path, run: MeasuredRun, count: int
) -> None:
    """A bag has a profile of each that there was when the recording began."""
    plain = read_bag(write(tmp_path / "plain", run))
    with BagWriter(tmp_path / "bag") as writer:
        for name in plain:
            topic = plain[name].topic
            own = count if name == "/joint_states" else 1
            writer.add_topic(replaced(topic, qos=({"reliability": "reliable"},) * own))
            for when, payload in zip(plain[name].log_time, plain[name].payloads, strict=True):
                writer.write(name, payload, int(when), int(when))
    remarks = "".join(read_run(tmp_path / "bag").remarks)
    assert ("(2 of /joint_states)" in remarks) == (count == 2)


@pytest.mark.parametrize(
    ("factor", "odd"), [(1.0, False), (1e-3, True), (1e-5, True), (10.0, True)]
)
def test_pressures_in_other_units_are_told(
    tmp_path: Path, run: MeasuredRun, factor: float, odd: bool
) -> None:
    """In kPa or bar; the paper's rig is far above what any atmosphere leaves."""

    def scaled(topic: str, _: int, time: float, value: float) -> tuple[float, float]:
        return time, value * (factor if topic.startswith("/chamber") else 1.0)

    remarks = "".join(read_run(write(tmp_path / "bag", run, scaled)).remarks)
    assert ("/chamber_a/pressure: " in remarks and "in kPa or bar" in remarks) == odd


def test_a_rig_beside_the_one_at_the_root_is_told(tmp_path: Path, run: MeasuredRun) -> None:
    """What is read is said where nobody has chosen; who gives a namespace has."""
    plain = read_bag(write(tmp_path / "plain", run))
    with BagWriter(tmp_path / "bag") as writer:
        for prefix in ("", "/left", "/_throttled"):
            for name in plain:
                writer.add_topic(replaced(plain[name].topic, name=f"{prefix}{name}"))
                for when, data in zip(plain[name].log_time, plain[name].payloads, strict=True):
                    writer.write(f"{prefix}{name}", data, int(when), int(when))
    (said,) = read_run(tmp_path / "bag").remarks
    assert said.endswith("also holds joint_states of /left; a namespace would choose that")
    assert read_run(tmp_path / "bag", "/left").remarks == ()


def with_more(
    bag: Path, path: Path, topic: BagTopic, messages: dict[float, Any], prefix: str = ""
) -> Path:
    """Write ``bag`` once more with the messages of another topic, by the time (s) of each.

    Its own topics get the ``prefix``.
    """
    plain = read_bag(bag)
    with BagWriter(path) as writer:
        for name in plain:
            writer.add_topic(replaced(plain[name].topic, name=f"{prefix}{name}"))
            for when, data in zip(plain[name].log_time, plain[name].payloads, strict=True):
                writer.write(f"{prefix}{name}", data, int(when), int(when))
        writer.add_topic(topic)
        for time, message in messages.items():
            when = round(time * 1e9)
            writer.write(topic.name, serialize_message(message), when, when)
    return path


def with_faults(bag: Path, path: Path, courses: dict[float, dict[str, str]]) -> Path:
    """Write ``bag`` once more with what its plant says of its faults, by the time (s) of each."""
    messages = {}
    for time, faults in courses.items():
        values = [KeyValue(key=name, value=value) for name, value in faults.items()]
        messages[time] = DiagnosticArray(status=[DiagnosticStatus(values=values)])
        messages[time].header.stamp.nanosec = round(time * 1e9)
    return with_more(
        bag, path, BagTopic("/faults", "diagnostic_msgs/msg/DiagnosticArray"), messages
    )


def test_faults_of_a_recording_are_told(tmp_path: Path, run: MeasuredRun) -> None:
    """Faults in a bag are named with their times, as a replay departs where they were active.

    Not those whose effect the recording holds: of the supply, and of the valve where what that held
    was recorded; nor those that ended before the run.
    """
    courses = {
        0.0: {"fault.valve.offset": "0.2 V", "fault.supply.loss": "0.3"},
        0.02: {"fault.carriage.seized": "true", "fault.valve.offset": "0.2 V"},
        0.05: {},
        0.06: {"fault.tube_a.burst": "1e-06 m²", "not a fault": "x"},
    }
    held = with_faults(write(tmp_path / "a", run, held=True), tmp_path / "held", courses)
    (said,) = read_run(held).remarks
    assert said.startswith(f"{held}: /faults: faults were active (fault.carriage.seized 0.020 to ")
    assert "seized 0.020 to 0.050 s, fault.tube_a.burst 0.060 to 0.100 s); a simulated" in said
    asked = with_faults(write(tmp_path / "b", run), tmp_path / "asked", courses)
    (said,) = read_run(asked).remarks
    assert "fault.valve.offset 0.000 to 0.050 s, fault.carriage.seized" in said
    none = with_faults(tmp_path / "a", tmp_path / "none", {0.0: {}})
    assert read_run(none).remarks == ()


def test_parameters_that_changed_in_a_recording_are_told(tmp_path: Path, run: MeasuredRun) -> None:
    """A replay was up to 1.6 mm away from a bag that says why, and nothing said so.

    Not told: of the supply, which was recorded, of another node, of a time after the run, and of
    what a node has declared. ``valve/state`` holds what the valve followed.
    """

    def of(node: str, *names: str, new: bool = False) -> ParameterEvent:
        kind = "new_parameters" if new else "changed_parameters"
        return ParameterEvent(node=node, **{kind: [Parameter(name=name) for name in names]})

    events = {
        0.01: of("/plant", "valve.hysteresis", new=True),
        0.0205: of("/plant", "supply.pressure", "cylinder.moving_mass", "fault.piston.leak"),
        0.03: of("/left/plant", "rail.tilt"),
        0.04: of("/controller", "controller.kp"),
        0.05: of("/plant", "cylinder.moving_mass", "friction.drift", "valve.command_timeout"),
        1.0: of("/plant", "rail.tilt"),
    }
    topic = BagTopic("/parameter_events", "rcl_interfaces/msg/ParameterEvent")
    changed = with_more(write(tmp_path / "a", run, held=True), tmp_path / "b", topic, events)
    assert read_run(changed).remarks == (
        f"{changed}: /parameter_events: parameters of the plant were set (cylinder.moving_mass at "
        "0.020 s, the last of 2 times at 0.050 s, fault.piston.leak at 0.020 s, friction.drift at "
        "0.050 s); a simulated rig keeps those it begins with",
    )
    told = with_faults(changed, tmp_path / "told", {0.0: {}})
    (said,) = read_run(told).remarks
    assert "fault" not in said, "/faults tells of that"
    left = with_more(tmp_path / "a", tmp_path / "left", topic, events, "/left")
    (said,) = read_run(left, "/left").remarks
    assert "were set (rail.tilt); a simulated" in said
    other = BagTopic("/parameter_events", "diagnostic_msgs/msg/DiagnosticArray")
    foreign = with_more(tmp_path / "a", tmp_path / "c", other, {0.02: DiagnosticArray()})
    assert read_run(foreign).remarks == ()


def test_what_others_publish_as_faults_says_nothing(tmp_path: Path, run: MeasuredRun) -> None:
    """A topic of that name with messages of another type leaves a bag as readable as it was."""
    plain = read_bag(write(tmp_path / "plain", run))
    with BagWriter(tmp_path / "bag") as writer:
        for name in plain:
            for one in (name, *(["/faults"] if name == "/joint_states" else [])):
                writer.add_topic(replaced(plain[name].topic, name=one))
                for when, data in zip(plain[name].log_time, plain[name].payloads, strict=True):
                    writer.write(one, data, int(when), int(when))
    assert read_run(tmp_path / "bag").remarks == ()


# Where the stamp of a message in CDR ends: after 4 bytes of representation and 8 of its own.
STAMP = 12


@pytest.mark.parametrize("topic", ["/chamber_b/pressure", "/valve/state"])
def test_two_messages_of_one_stamp_are_told(tmp_path: Path, run: MeasuredRun, topic: str) -> None:
    """Two plants of one name, which send at the same instants what the other one does later."""
    plain = read_bag(write(tmp_path / "plain", run, held=True))
    with BagWriter(tmp_path / "bag") as writer:
        for name in plain:
            writer.add_topic(plain[name].topic)
            sent = plain[name].payloads
            for k, when in enumerate(plain[name].log_time.tolist()):
                writer.write(name, sent[k], when, when)
                if name == topic:
                    writer.write(name, sent[k][:STAMP] + sent[-1 - k][STAMP:], when, when)
    remarks = "".join(read_run(tmp_path / "bag").remarks)
    assert f"{topic}: several messages have one stamp" in remarks


def test_every_other_stamp_may_be_anothers(tmp_path: Path, run: MeasuredRun) -> None:
    """Two plants at the same instants are read by their even times, whatever those are worth."""
    plain = read_bag(write(tmp_path / "plain", run, held=True))
    with BagWriter(tmp_path / "bag") as writer:
        for name in plain:
            writer.add_topic(plain[name].topic)
            for k, when in enumerate(plain[name].log_time.tolist()):
                writer.write(name, plain[name].payloads[k], when, when)
                if name == "/joint_states" and k:
                    other = plain[name].messages[k]
                    other.position[0] += 1e-3
                    writer.write(name, serialize_message(other), when, when)
    again = read_run(tmp_path / "bag")
    assert again.period == pytest.approx(read_run(tmp_path / "plain").period, rel=1e-12)
    assert "several messages have one stamp" in "".join(again.remarks)


def test_samples_that_were_offered_again_are_no_other_plants(
    tmp_path: Path, run: MeasuredRun
) -> None:
    """A lock-step plant repeats what is not answered at once: the run is the one without."""
    plain = read_bag(write(tmp_path / "plain", run, held=True))
    with BagWriter(tmp_path / "bag") as writer:
        for name in plain:
            writer.add_topic(plain[name].topic)
        for k in range(len(plain["/joint_states"])):
            for _ in range(1 + k % 3):
                for name in plain:
                    when = int(plain[name].log_time[k])
                    writer.write(name, plain[name].payloads[k], when, when)
    once, again = read_run(tmp_path / "plain"), read_run(tmp_path / "bag")
    assert again.remarks == once.remarks == ()
    assert np.array_equal(again.voltage, once.voltage)
    assert np.array_equal(again.position, once.position)


@pytest.mark.parametrize("times", [1, 2])
def test_more_commands_than_samples_are_in_doubt(
    tmp_path: Path, run: MeasuredRun, times: int
) -> None:
    """Positions that come less often than commands, without what the valve held."""

    def fewer(topic: str, sample: int, time: float, value: float) -> tuple[float, float] | None:
        return (time, value) if sample % times == 0 or topic != "/joint_states" else None

    doubt = read_run(write(tmp_path / "bag", run, fewer)).doubt
    assert ("commands answer 51 samples" in doubt) == (times == 2)
