# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Names, types, units and stamps of everything the two nodes offer to others."""

import itertools
import json
import math
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from xml.etree import ElementTree

import pytest
from rcl_interfaces.msg import ParameterEvent
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy
from rosgraph_msgs.msg import Clock
from running import StartRig
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Float64

from rodless_base.ros.topics import stamp_nanoseconds
from rodless_lab.session.errors import WaitTimeoutError
from rodless_lab.session.observer import Observer
from rodless_sim import RigParameters

ROOT = Path(__file__).resolve().parents[2]
PARAMETERS = RigParameters.preset("paper")
PERIOD = 5_000_000

FLOAT, TRIGGER, SWITCH = "std_msgs/msg/Float64", "std_srvs/srv/Trigger", "std_srvs/srv/SetBool"
PRESSURE, JOINT = "sensor_msgs/msg/FluidPressure", "sensor_msgs/msg/JointState"

# Below the namespace, {node: {topic: type}}; a name with a slash before it is absolute.
PUBLISHED = {
    "plant": {
        "joint_states": JOINT,
        "chamber_a/pressure": PRESSURE,
        "chamber_b/pressure": PRESSURE,
        "supply/pressure": PRESSURE,
        "valve/state": JOINT,
        "faults": "diagnostic_msgs/msg/DiagnosticArray",
        "/clock": "rosgraph_msgs/msg/Clock",
        "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
    },
    "controller": {
        "valve/voltage": FLOAT,
        "controller/reference": FLOAT,
        "controller/error": FLOAT,
        "controller/p": FLOAT,
        "controller/i": FLOAT,
        "controller/d": FLOAT,
        "controller/feedforward": FLOAT,
        "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
    },
}
# Of these the last message, for whoever only looks on.
THROTTLED = {
    "plant": (
        "joint_states",
        "chamber_a/pressure",
        "chamber_b/pressure",
        "supply/pressure",
        "valve/state",
    ),
    "controller": (
        "controller/reference",
        "controller/error",
        "controller/p",
        "controller/i",
        "controller/d",
        "controller/feedforward",
    ),
}
SUBSCRIBED = {
    "plant": {"valve/voltage": FLOAT},
    "controller": {
        "joint_states": JOINT,
        "setpoint": FLOAT,
        "joint_commands": JOINT,
        "controller/joint_trajectory": "trajectory_msgs/msg/JointTrajectory",
        "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",  # of its plant
    },
}
SERVICES = {
    "plant": {"plant/reset": TRIGGER, "plant/pause": SWITCH, "plant/step": TRIGGER},
    "controller": {"controller/reset": TRIGGER, "controller/enable": SWITCH},
}

# What rclpy itself gives every node. The services of simulation_interfaces, offered where that
# package is, have tests of their own.
OF_RCLPY = ("/rosout", "/parameter_events", "/describe_parameters", "/get_parameters",
            "/get_parameter_types", "/list_parameters", "/set_parameters",
            "/set_parameters_atomically", "/get_type_description")  # fmt: skip

PERIOD_PARAMETER = {"time.period": PERIOD * 1e-9}


# Of each type that a layout shows, the fields with numbers.
NUMBERS = {
    FLOAT: {"data"},
    PRESSURE: {"fluid_pressure"},
    JOINT: {"position", "velocity", "effort"},
}


@pytest.fixture(scope="module", autouse=True)
def rig(start_rig: StartRig) -> Iterator[None]:
    """Run a rig in the root namespace."""
    with start_rig(plant=PERIOD_PARAMETER):
        yield


def offered(found: list[tuple[str, list[str]]]) -> dict[str, str]:
    """What a node offers besides what rclpy gives every node, by name."""
    return {
        name: types[0]
        for name, types in found
        if not name.endswith(OF_RCLPY) and not types[0].startswith("simulation_interfaces/")
    }


def below(namespace: str, names: dict[str, str]) -> dict[str, str]:
    """Absolute names of a table above for one namespace."""
    return {
        name if name.startswith("/") else f"{namespace}/{name}": kind
        for name, kind in names.items()
    }


def check_graph(observer: Observer, node: str, namespace: str, published: dict[str, str]) -> None:
    """Wait until ``node`` offers exactly what the tables say."""
    graph, where = observer.node, namespace or "/"
    throttled = {f"_throttled/{name}": published[name] for name in THROTTLED[node]}
    # Nodes of the same process are discovered at once, their endpoints one after another.
    observer.wait(lambda: (node, where) in graph.get_node_names_and_namespaces(), f"node {node}")
    all_published = below(namespace, {**published, **throttled})
    wanted = all_published, below(namespace, SUBSCRIBED[node]), SERVICES[node]
    found: list[dict[str, str]] = []

    def complete() -> bool:
        found[:] = [
            offered(graph.get_publisher_names_and_types_by_node(node, where)),
            offered(graph.get_subscriber_names_and_types_by_node(node, where)),
            offered(graph.get_service_names_and_types_by_node(node, where)),
        ]
        return found == [wanted[0], wanted[1], below(namespace, wanted[2])]

    try:
        observer.wait(complete, f"the interface of {node}", 20.0)
    except WaitTimeoutError:
        assert found == [wanted[0], wanted[1], below(namespace, wanted[2])]


@pytest.mark.parametrize("node", ["plant", "controller"])
def test_offers_exactly_the_topics_and_services_of_the_design(
    observer: Observer, node: str
) -> None:
    """Every topic and service of the table is there under its name and type, and no other."""
    check_graph(observer, node, "", PUBLISHED[node])


@pytest.mark.parametrize("node", ["plant", "controller"])
def test_publishers_lose_nothing_and_keep_nothing_for_later(observer: Observer, node: str) -> None:
    """What the nodes publish is reliable and volatile: streams, not states to catch up with.

    Faults are such a state: whoever comes later is told what there is.
    """
    latched = DurabilityPolicy.TRANSIENT_LOCAL
    for topic in below("", PUBLISHED[node]):
        observer.wait(lambda topic=topic: observer.node.count_publishers(topic), topic)
        for info in observer.node.get_publishers_info_by_topic(topic):
            assert info.qos_profile.reliability == ReliabilityPolicy.RELIABLE, topic
            durability = latched if topic == "/faults" else DurabilityPolicy.VOLATILE
            assert info.qos_profile.durability == durability, topic


def test_events_of_the_controller_are_dated_in_plant_time(observer: Observer) -> None:
    """By its samples: it does not listen to /clock."""
    assert observer.get_parameters("/controller", ["use_sim_time"]) == {"use_sim_time": True}
    events = observer.collect(ParameterEvent, "/parameter_events")
    gains = itertools.count(60)

    def stamps() -> list[int]:
        return [stamp for event in events if (stamp := stamp_nanoseconds(event.stamp)) > 0]

    def dated() -> bool:
        # A change that comes before controller and observer have found each other goes unheard.
        observer.set_parameters("/controller", {"controller.kd": float(next(gains))})
        return bool(stamps())

    observer.wait(dated, "a date")
    assert stamps()[-1] < 86_400 * 10**9  # of the wall clock it would be decades


def test_joint_is_the_carriage_in_si_units(observer: Observer) -> None:
    """Position in m within the stroke, its change the velocity in m/s, effort A·(P_a − P_b) in N.

    The carriage is sent to 20 mm, so that there is something to see.
    """
    samples = observer.collect(JointState, "/joint_states")
    pressures = [observer.collect(FluidPressure, f"/chamber_{one}/pressure") for one in "ab"]
    observer.publisher(Float64, "/setpoint").publish(Float64(data=0.02))
    observer.wait(
        lambda: samples and abs(samples[-1].position[0] - 0.02) < 5e-4, "the carriage at 20 mm"
    )
    observer.more(samples, 20)
    assert all(list(sample.name) == ["carriage"] for sample in samples)
    assert all(-1e-3 < sample.position[0] < 0.201 for sample in samples)
    moved = samples[-1].position[0] - samples[0].position[0]
    integral = sum(sample.velocity[0] for sample in samples[1:]) * PERIOD * 1e-9
    assert integral == pytest.approx(moved, abs=2e-3)
    area = math.pi / 4 * PARAMETERS.number("cylinder.bore") ** 2
    force = {stamp_nanoseconds(sample.header.stamp): sample.effort[0] for sample in samples}
    by_stamp = [
        {stamp_nanoseconds(message.header.stamp): message.fluid_pressure for message in side}
        for side in pressures
    ]
    common = force.keys() & by_stamp[0].keys() & by_stamp[1].keys()
    assert len(common) > 20
    for stamp in common:
        assert force[stamp] == pytest.approx(
            area * (by_stamp[0][stamp] - by_stamp[1][stamp]), abs=1e-6
        )


def test_pressures_are_absolute_pascals_in_frames_of_their_own(observer: Observer) -> None:
    """Supply is 0.52 MPa gauge, so 621 325 Pa; chambers lie between ambient and supply."""
    supply = PARAMETERS.number("supply.pressure")
    ambient = PARAMETERS.number("atmosphere.pressure")
    for frame in ("chamber_a", "chamber_b", "supply"):
        messages = observer.collect(FluidPressure, f"/{frame}/pressure")
        for message in observer.more(messages, 5):
            assert message.header.frame_id == frame
            assert message.variance == 0.0, "the message defines 0 as unknown"
            assert ambient <= message.fluid_pressure <= supply
            if frame == "supply":
                assert message.fluid_pressure == pytest.approx(621_325.0)


def test_stamps_are_plant_time_one_period_apart_and_the_same_on_every_topic(
    observer: Observer,
) -> None:
    """Stamps grow by exactly one period, on samples and pressures; /clock shows each of them."""
    joints = observer.collect(JointState, "/joint_states")
    pressures = observer.collect(FluidPressure, "/supply/pressure")
    clocks = observer.collect(Clock, "/clock")
    observer.wait(lambda: min(len(joints), len(pressures), len(clocks)) > 200, "200 samples")
    stamps = [
        [stamp_nanoseconds(message.header.stamp) for message in joints],
        [stamp_nanoseconds(message.header.stamp) for message in pressures],
        [stamp_nanoseconds(message.clock) for message in clocks],
    ]
    first = max(times[0] for times in stamps)
    last = min(times[-1] for times in stamps)
    assert last - first > 100 * PERIOD
    for times in stamps:
        assert [t for t in times if first <= t <= last] == list(range(first, last + 1, PERIOD))


def test_commands_are_volts_of_the_valve(observer: Observer) -> None:
    """Commands stay within 0-10 V."""
    for message in observer.more(observer.collect(Float64, "/valve/voltage"), 50):
        assert 0.0 <= message.data <= 10.0


def test_a_namespace_makes_a_second_rig_that_does_not_hear_the_first(
    observer: Observer, start_rig: StartRig
) -> None:
    """A rig in /second has all its names there, and each rig answers to its own set-point alone.

    Plant time is one topic for all, so the second rig is told to leave /clock to the first.
    """
    samples = observer.collect(JointState, "/joint_states")
    observer.publisher(Float64, "/setpoint").publish(Float64(data=0.02))
    observer.wait(
        lambda: samples and abs(samples[-1].position[0] - 0.02) < 5e-4, "the first at 20 mm"
    )
    with start_rig(namespace="second", plant={**PERIOD_PARAMETER, "time.publish_clock": False}):
        published = {k: v for k, v in PUBLISHED["plant"].items() if k != "/clock"}
        published["clock"] = PUBLISHED["plant"]["/clock"]
        check_graph(observer, "plant", "/second", published)
        check_graph(observer, "controller", "/second", PUBLISHED["controller"])
        assert observer.node.count_publishers("/clock") == 1
        others = observer.collect(JointState, "/second/joint_states")
        setpoint = observer.publisher(Float64, "/second/setpoint")
        observer.more(others, 100)
        assert max(sample.position[0] for sample in others) < 1e-4
        start = len(samples)
        setpoint.publish(Float64(data=0.01))
        observer.wait(lambda: abs(others[-1].position[0] - 0.01) < 5e-4, "the second at 10 mm")
        assert all(abs(sample.position[0] - 0.02) < 1e-3 for sample in samples[start:])


def shown_by_foxglove() -> Iterator[tuple[str, str]]:
    """Topic and field of each path of the layout."""
    layout = json.loads((ROOT / "description" / "foxglove.json").read_text(encoding="utf-8"))
    for panel in layout["configById"].values():
        for path in panel.get("paths", []):
            topic, _, field = path["value"].partition(".")
            yield topic, field.removesuffix("[0]")


def shown_by_plotjuggler() -> Iterator[tuple[str, str]]:
    """Topic and field of each curve of the layout; a joint's name stands between them."""
    root = ElementTree.parse(ROOT / "description" / "plotjuggler.xml").getroot()
    for source in root.iter("linked_source"):
        topic, _, field = str(source.text).rpartition("/")
        yield topic.removesuffix("/carriage").removesuffix("/valve_spool"), field


Shown = Callable[[], Iterator[tuple[str, str]]]


@pytest.mark.parametrize("shown", [shown_by_foxglove, shown_by_plotjuggler])
def test_layouts_show_what_the_nodes_publish(
    shown: Callable[[], Iterator[tuple[str, str]]],
) -> None:
    """Each topic of a layout is in the tables above, and its type has the field as a number."""
    topics = below(
        "", {**SUBSCRIBED["controller"], **PUBLISHED["plant"], **PUBLISHED["controller"]}
    )
    found = list(shown())
    assert len(found) > 8
    for topic, field in found:
        assert field in NUMBERS[topics[topic]], (topic, field)
    first_picture = {
        "/joint_states",
        "/chamber_a/pressure",
        "/chamber_b/pressure",
        "/valve/voltage",
    }
    assert first_picture <= {topic for topic, _ in found}


def test_the_panels_of_foxglove_are_all_in_sight() -> None:
    """Every panel has a place in the layout; the button publishes what the controller takes."""
    layout = json.loads((ROOT / "description" / "foxglove.json").read_text(encoding="utf-8"))

    def panels(place: dict | str) -> list[str]:
        if isinstance(place, str):
            return [place]
        return panels(place["first"]) + panels(place["second"])

    assert sorted(panels(layout["layout"])) == sorted(layout["configById"])
    button = layout["configById"]["Publish!setpoint"]
    assert below("", SUBSCRIBED["controller"])[button["topicName"]] == button["datatype"]
    assert json.loads(button["value"]) == {"data": 0.058}
    state = layout["configById"]["DiagnosticSummary!state"]
    assert state["topicToRender"] in PUBLISHED["plant"]


def test_the_page_of_topics_names_them_all() -> None:
    """docs/topics.md has each topic and service of the tables above."""
    page = (ROOT / "docs" / "topics.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`([~/\w]+)`", page))
    for node in ("plant", "controller"):
        throttled = [f"_throttled/{name}" for name in THROTTLED[node]]
        for name in (*PUBLISHED[node], *SUBSCRIBED[node], *SERVICES[node], *throttled):
            assert {name, name.replace(f"{node}/", "~/")} & named, name
