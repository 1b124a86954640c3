# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless rig`: its options reach the nodes, and Ctrl-C ends both."""

import signal
from pathlib import Path

import numpy as np
import pytest
from extent import extensive
from rosgraph_msgs.msg import Clock
from running import StartProcess
from std_msgs.msg import Float64

from rodless_lab import read_bag
from rodless_lab.session.observer import Observer
from rodless_sim import RigParameters
from rodless_sim.instruments.instruments import IDEAL

# Both nodes have two seconds to end.
STOP_SECONDS = 4.0


def test_options_reach_the_nodes_and_ctrl_c_ends_them(
    rodless: StartProcess, observer: Observer, tmp_path: Path
) -> None:
    """Preset, sensors, cylinder, clock, file and supply are in force; SIGINT ends all with 0."""
    file = tmp_path / "mine.yaml"
    file.write_text("/**/plant:\n  ros__parameters:\n    cylinder.moving_mass: 1.5\n")
    options = (
        "rig --preset calibrated --sensors ideal --supply-pressure 600000 "
        "--cylinder CY3R32-500 --no-clock"
    )
    form = RigParameters.preset("calibrated")["friction.form"]
    expected = {**IDEAL, "supply.pressure": 6e5, "friction.form": form}
    expected["cylinder.moving_mass"] = 1.5
    expected |= {"cylinder.bore": 0.032, "cylinder.stroke": 0.5, "time.publish_clock": False}
    assert form != RigParameters()["friction.form"]
    with rodless(*options.split(), "--namespace", "left", "--parameters", str(file)) as rig:
        assert observer.get_parameters("/left/plant", expected) == expected
        reach = {"reference.maximum": 0.5}
        assert observer.get_parameters("/left/controller", reach) == reach
        observer.wait(lambda: observer.node.count_publishers("/left/valve/voltage"), "a controller")
        rig.signal(signal.SIGINT)
        assert rig.wait(STOP_SECONDS) == 0


@extensive
def test_the_plant_can_be_started_alone(rodless: StartProcess, observer: Observer) -> None:
    """Without the controller nobody commands the valve."""
    with rodless("rig", "--without-controller", "--namespace", "alone") as rig:
        observer.get_parameters("/alone/plant", ["supply.pressure"])
        assert observer.node.count_publishers("/alone/valve/voltage") == 0
        assert ("controller", "/alone") not in observer.node.get_node_names_and_namespaces()
        with rodless("get", "--namespace", "alone") as get:
            assert get.wait() == 0
        assert "\nsupply.pressure=" in get.output
        assert "no controller in namespace /alone" in get.output.splitlines()[-1]
        rig.signal(signal.SIGINT)
        assert rig.wait(STOP_SECONDS) == 0


def test_it_records_itself_until_ctrl_c(
    rodless: StartProcess, observer: Observer, tmp_path: Path
) -> None:
    """In one process, from sample 0 on; the bag is closed and its messages are counted."""
    bag = tmp_path / "bag"
    with rodless("rig", "--namespace", "taped", "--record", str(bag)) as rig:
        topic = "/taped/valve/voltage"
        listeners = observer.node.get_subscriptions_info_by_topic
        observer.wait(lambda: "recorder" in {of.node_name for of in listeners(topic)}, "a recorder")
        observer.more(observer.collect(Float64, topic), 10)
        rig.signal(signal.SIGINT)
        assert rig.wait() == 0
        assert f"messages in {bag}" in rig.output
    read = read_bag(bag)
    for topic in ("/taped/joint_states", "/taped/valve/state", "/taped/supply/pressure", "/clock"):
        assert read[topic].log_time[0] == 0
        assert np.all(np.diff(read[topic].log_time) == 1_000_000)
    assert len(read["/taped/valve/voltage"]) > 0


@extensive
def test_a_rig_that_leaves_clock_to_another_dates_its_bag_by_its_own(
    rodless: StartProcess, start_node: StartProcess, observer: Observer, tmp_path: Path
) -> None:
    """Each message has the time of its sample, although the neighbour's time is far ahead."""
    bag = tmp_path / "bag"
    with start_node("plant", {"time.speed": 10.0, "time.period": 5e-3}, namespace="ahead"):
        clock = observer.collect(Clock, "/clock")
        observer.wait(lambda: clock and clock[-1].clock.sec > 20, "a time that is far ahead")
        with rodless("rig", "--namespace", "quiet", "--no-clock", "--record", str(bag)) as rig:
            observer.more(observer.collect(Float64, "/quiet/valve/voltage"), 10)
            rig.signal(signal.SIGINT)
            assert rig.wait() == 0
    read = read_bag(bag)
    for topic in ("/quiet/joint_states", "/quiet/supply/pressure", "/quiet/clock"):
        assert read[topic].log_time[0] == 0
        assert np.all(np.diff(read[topic].log_time) == 1_000_000)
    assert read["/quiet/valve/voltage"].log_time[-1] <= read["/quiet/clock"].log_time[-1]
    assert "/clock" not in read


def test_a_plant_alone_does_not_record_itself(rodless: StartProcess) -> None:
    """Exit code 2, and what to use instead."""
    with rodless("rig", "--without-controller", "--record") as rig:
        assert rig.wait() == 2
        assert "use `rodless record` here" in rig.output


@pytest.mark.parametrize(
    "options",
    ["--parameters nowhere.yaml", "--preset papier", "--scenario nowhere.yaml", "--scenario /"],
)
def test_what_is_not_there_is_named(rodless: StartProcess, options: str) -> None:
    """A file or preset that does not exist: exit code 2, and its name."""
    with rodless("rig", *options.split()) as rig:
        assert rig.wait() == 2
        assert options.split()[1] in rig.output
        assert "Traceback" not in rig.output


def test_a_cylinder_that_is_none_is_refused(rodless: StartProcess) -> None:
    """Before anything starts, with exit code 2 and the form of a model number."""
    with rodless("rig", "--cylinder", "CY3R26-100") as rig:
        assert rig.wait() == 2
        assert "the series has the bores 6, 10, 15" in rig.output
