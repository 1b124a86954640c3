# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Bags that others write: joints in any order, other robots' joints, clocks and ends of topics."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from builtin_interfaces.msg import Time
from rclpy.serialization import serialize_message
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Float64, Header

from rodless_lab import read_commands, read_run
from rodless_lab.bags.metadata import BagTopic
from rodless_lab.bags.writer import BagWriter
from rodless_lab.runs.measured_run import RunError
from rodless_lab.view.errors import ViewError
from rodless_lab.view.playback import open_tape
from rodless_lab.view.samples import COLUMNS

SAMPLES = 1000
PERIOD = 1e-3
TYPES = {
    "/joint_states": "sensor_msgs/msg/JointState",
    "/chamber_a/pressure": "sensor_msgs/msg/FluidPressure",
    "/chamber_b/pressure": "sensor_msgs/msg/FluidPressure",
    "/supply/pressure": "sensor_msgs/msg/FluidPressure",
    "/valve/state": "sensor_msgs/msg/JointState",
    "/valve/voltage": "std_msgs/msg/Float64",
    "/controller/reference": "std_msgs/msg/Float64",
}
PRESSURES = [topic for topic in TYPES if topic.endswith("pressure")]

# When everything changes, and what the carriage does from then on.
CHANGE = 0.5

Joint = tuple[str, float, float]  # name, m, m/s
OTHERS: list[Joint] = [("shoulder", 1.57, 3.0), ("elbow", -0.4, 0.0)]


def carriage(time: float) -> Joint:
    """Where it is (m), and how fast (m/s)."""
    late = time >= CHANGE
    return "carriage", 0.05 + 0.01 * time, 0.01 if late else 0.0


def joint_state(header: Header, joints: Sequence[Joint]) -> JointState:
    """One message of these joints, in this order."""
    names, positions, velocities = (list(column) for column in zip(*joints, strict=True))
    return JointState(header=header, name=names, position=positions, velocity=velocities)


def alone(_sample: int, own: Joint) -> Iterator[list[Joint]]:
    """The rig's own message."""
    yield [own]


def in_turns(sample: int, own: Joint) -> Iterator[list[Joint]]:
    """Joints in another order each time, as a message of several publishers' joints may have."""
    joints = [own, *OTHERS]
    turn = sample % 3
    yield joints[turn:] + joints[:turn]


def prefixed(_sample: int, own: Joint) -> Iterator[list[Joint]]:
    """A joint with the prefix of its rig, behind another."""
    yield [OTHERS[0], (f"left/{own[0]}", *own[1:])]


def beside_another_robot(sample: int, own: Joint) -> Iterator[list[Joint]]:
    """Another robot's publisher on the same topic, now before, now after the rig's message."""
    messages = [[own], OTHERS]
    yield from messages if sample % 2 else reversed(messages)


def from_half_way(sample: int, own: Joint) -> Iterator[list[Joint]]:
    """Another publisher takes the topic over, its joints in another order."""
    yield [own, OTHERS[0]] if sample < SAMPLES // 2 else [OTHERS[0], own]


def write(
    path: Path,
    joints=alone,
    clock: float = 0.0,
    stamped: bool = True,
    ends: float = 2.0,
    state_names=lambda _sample: ["valve_spool"],
) -> Path:
    """Write a bag whose log times begin at ``clock`` (s), its pressures up to ``ends`` (s)."""
    with BagWriter(path) as writer:
        for topic, kind in TYPES.items():
            writer.add_topic(BagTopic(topic, kind))
        for k in range(SAMPLES):
            time, late = k * PERIOD, float(k * PERIOD >= CHANGE)
            log_time = round((time + clock) * 1e9)
            nanoseconds = round(time * 1e9) if stamped else 0
            stamp = Time(sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)
            header = Header(stamp=stamp)

            def put(topic: str, message: object, when: int = log_time) -> None:
                writer.write(topic, serialize_message(message), when, when)

            for joints_of_one in joints(k, carriage(time)):
                put("/joint_states", joint_state(header, joints_of_one))
            for topic in PRESSURES if time < ends else ():
                put(topic, FluidPressure(header=header, fluid_pressure=4e5 + 1e5 * time))
            spools = state_names(k)
            spool = JointState(
                name=spools,
                position=[1e-4 * late] * len(spools),
                effort=[5.08 + late] * len(spools),
            )
            spool.header = header
            put("/valve/state", spool)
            put("/valve/voltage", Float64(data=5.08 + late))
            put("/controller/reference", Float64(data=0.05 + 0.05 * late))
    return path


@pytest.mark.parametrize("joints", [alone, in_turns, prefixed, beside_another_robot, from_half_way])
def test_a_run_is_of_its_carriage_whoever_else_publishes(tmp_path: Path, joints) -> None:
    """Each message has its own order of joints; what names other joints alone is another's."""
    path = write(tmp_path / "bag", joints)
    run = read_run(path)
    np.testing.assert_allclose(run.position, 0.05 + 0.01 * run.time, atol=1e-12)
    assert len(run.time) == SAMPLES
    assert run.notes == ()
    assert read_commands(path).sample.tolist() == list(range(SAMPLES))
    velocity = open_tape(path).columns[list(COLUMNS).index("velocity")]
    np.testing.assert_allclose(velocity, [carriage(time)[2] for time in run.time], atol=1e-12)


def test_a_carriage_that_is_nowhere_is_named(tmp_path: Path) -> None:
    """The joints of all messages are listed."""
    path = write(tmp_path / "bag", lambda _k, _own: [[one] for one in OTHERS])
    with pytest.raises(RunError, match=r"no joint 'carriage' among elbow, shoulder$"):
        read_run(path)


@pytest.mark.parametrize(
    ("names", "said"),
    [
        (("left/carriage", "right/carriage"), "left/carriage, right/carriage may each be the carr"),
        (("mine/carriage", "printer_carriage"), "mine/carriage, printer_carriage may each be the"),
        (("carriage", "right/carriage"), ""),
        (("carriage", "printer_carriage"), ""),
    ],
)
def test_two_carriages_are_not_one(tmp_path: Path, names: tuple[str, str], said: str) -> None:
    """One that has no prefix is meant; of several with one, none, and all are named."""

    def both(_sample: int, own: Joint) -> Iterator[list[Joint]]:
        yield [(names[0], *own[1:])]
        yield [(names[1], 0.15, 0.0)]

    path = write(tmp_path / "bag", both)
    if said:
        with pytest.raises(RunError, match=said):
            read_run(path)
    else:
        assert read_run(path).position == pytest.approx(0.05 + 0.01 * read_run(path).time)


def test_a_joint_without_a_name_must_be_alone(tmp_path: Path) -> None:
    """One position without any name is the carriage's; of two nobody knows which is."""
    one = write(tmp_path / "one", lambda _k, own: [[("", *own[1:])]])
    assert read_run(one).position[0] == 0.05
    two = write(tmp_path / "two", lambda _k, own: [[("", *own[1:]), ("", 1.57, 0.0)]])
    with pytest.raises(RunError, match="no joint 'carriage' among"):
        read_run(two)


def test_what_is_wrong_with_another_joint_is_said_by_the_view_too(tmp_path: Path) -> None:
    """A piston whose stamps go back: in the words of a view, naming the bag."""

    def with_piston(sample: int, own: Joint) -> Iterator[list[Joint]]:
        yield [own]
        if sample == 0:
            yield [("left/piston", 0.1, 0.0)]
            yield [("right/piston", 0.1, 0.0)]

    path = write(tmp_path / "bag", with_piston)
    assert len(read_run(path).time) == SAMPLES
    with pytest.raises(ViewError, match=r"^bag: /joint_states: left/piston, right/piston may each"):
        open_tape(path)


@pytest.mark.parametrize("spools", [0, 1, 2])
def test_a_valve_that_is_hardly_recorded_is_taken_from_its_commands(
    tmp_path: Path, spools: int
) -> None:
    """Of fewer than two states nobody can tell when a voltage began."""

    def states(sample: int) -> list[str]:
        return ["valve_spool" if sample < spools else "another_spool", "elbow"]

    path = write(tmp_path / "bag", state_names=states)
    if spools == 0:
        with pytest.raises(RunError, match="no joint 'valve_spool' among"):
            read_run(path)
    else:
        assert len(read_run(path).time) >= SAMPLES - 2


@pytest.mark.parametrize(
    "how",
    [
        {},
        {"clock": 1.7e9},
        {"stamped": False},
        {"ends": 0.8},
    ],
    ids=["plant time", "wall time", "no stamps", "pressures end early"],
)
def test_all_that_a_page_draws_is_on_one_time(tmp_path: Path, how: dict[str, float]) -> None:
    """Velocity, spool, reference and voltage change when they did, whatever clock the bag has."""
    tape = open_tape(write(tmp_path / "bag", **how))  # type: ignore[arg-type]
    columns = dict(zip(COLUMNS, tape.columns, strict=True))
    for name in ("velocity", "spool", "reference", "voltage"):
        assert not np.isnan(columns[name]).any(), name
        (place,) = changes(columns[name])
        # The valve's state tells what was held up to its stamp.
        late = PERIOD if name in ("velocity", "spool", "reference") else 0.0
        assert columns["time"][place] == pytest.approx(CHANGE - PERIOD + late, abs=1e-6), name


def changes(values: npt.NDArray[np.float64]) -> list[int]:
    """Places where values differ from the one before."""
    return [k for k, (a, b) in enumerate(pairwise(values.tolist()), 1) if a != b]
