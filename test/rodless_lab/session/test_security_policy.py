# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The SROS2 policy in config/sros2 against the nodes themselves."""

from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from xml.etree import ElementTree

import pytest
from running import StartRig

from rodless_lab.session.observer import Observer
from rodless_lab.session.running_rig import NODES
from rodless_lab.session.security_policy import policy

ROOT = Path(__file__).resolve().parents[3]
FILE = ROOT / "config" / "sros2" / "rig.policy.xml"

# What the plant serves where simulation_interfaces is installed, which is not among the wheels. The
# file allows it, else such a plant could not start under the policy.
OPTIONAL_SERVICES = (
    "~/get_simulation_state",
    "~/get_simulator_features",
    "~/reset_simulation",
    "~/set_simulation_state",
    "~/step_simulation",
)

# For discovery on a crowded machine, in wall-clock s.
TIMEOUT = 120.0


@pytest.fixture
def rig(start_rig: StartRig) -> Iterator[None]:
    """Run a rig as `rodless rig` does."""
    with start_rig():
        yield


def allowed_here() -> str:
    """Return the policy in the file, without what the plant cannot serve here."""
    text = FILE.read_text(encoding="utf-8")
    for service in OPTIONAL_SERVICES:
        line = f"            <service>{service}</service>\n"
        assert text.count(line) == 1
        if find_spec("simulation_interfaces") is None:
            text = text.replace(line, "")
    return text


@pytest.mark.usefixtures("rig")
def test_the_policy_is_what_the_nodes_use(observer: Observer) -> None:
    """Each topic and service of the graph is allowed to its node, and no other."""
    expected = allowed_here()
    observer.wait(lambda: set(NODES) <= set(observer.node.get_node_names()), "both nodes", TIMEOUT)
    observer.wait(
        lambda: policy(observer.node, list(NODES)) == expected,
        "the graph of `rodless policy -o config/sros2/rig.policy.xml`",
        TIMEOUT,
    )


def test_the_policy_has_the_form_of_sros2() -> None:
    """A policy of enclaves, a profile for each node, rules that allow; names that are not empty."""
    root = ElementTree.parse(FILE).getroot()
    assert (root.tag, root.get("version")) == ("policy", "0.2.0")
    profiles = root.findall("enclaves/enclave/profiles/profile")
    assert [(one.get("ns"), one.get("node")) for one in profiles] == [("/", n) for n in NODES]
    kinds = {"topics": {"publish", "subscribe"}, "services": {"reply", "request"}}
    for profile in profiles:
        assert len(profile)
        for rule in profile:
            ((action, qualifier),) = rule.attrib.items()
            assert action in kinds[rule.tag]
            assert qualifier == "ALLOW"
            assert len(rule)
            assert all(one.tag == rule.tag[:-1] and one.text for one in rule)


def test_nobody_else_may_command_the_valve() -> None:
    """The controller alone publishes on valve/voltage, the plant alone samples."""
    root = ElementTree.parse(FILE).getroot()
    publishers = {
        (profile.get("node"), topic.text)
        for profile in root.iter("profile")
        for topics in profile.findall("topics[@publish]")
        for topic in topics
    }
    for topic, node in (("valve/voltage", "controller"), ("joint_states", "plant")):
        assert [who for who, what in publishers if what == topic] == [node]
