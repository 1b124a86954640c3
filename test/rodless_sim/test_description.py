# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The rig as URDF: what it says of the joint, and that all of it hangs together."""

import math
from xml.etree import ElementTree

import pytest

from rodless_base.topics import PRESSURES
from rodless_sim import RigParameters
from rodless_sim.description import robot_description

OTHER = {"cylinder.stroke": 0.5, "cylinder.bore": 0.063, "frame_prefix": "left/"}


def urdf(**values: object) -> ElementTree.Element:
    """Return the description of a rig of these parameters, read again."""
    return ElementTree.fromstring(robot_description(RigParameters(values)))


def test_the_joint_moves_as_far_and_as_hard_as_the_cylinder() -> None:
    """Limits from the parameters: the stroke, and π/4 · (25 mm)² · 0.52 MPa = 255.25 N."""
    for values, stroke, force in (({}, 0.2, 255.254), (OTHER, 0.5, 255.254 * (63 / 25) ** 2)):
        (joint,) = (j for j in urdf(**values).iter("joint") if j.get("type") == "prismatic")
        limit = joint.find("limit")
        assert limit is not None
        assert (float(limit.get("lower", "")), float(limit.get("upper", ""))) == (0.0, stroke)
        assert float(limit.get("effort", "")) == pytest.approx(force, rel=1e-4)
        axis = joint.find("axis")
        assert axis is not None
        assert axis.get("xyz") == "1 0 0"


@pytest.mark.parametrize(("values", "prefix"), [({}, ""), (OTHER, "left/")])
def test_frames_and_joint_are_those_of_the_messages(values: dict, prefix: str) -> None:
    """The joint of joint_states, and every frame_id of a pressure, each with the prefix."""
    robot = urdf(**values)
    links = [link.get("name") for link in robot.iter("link")]
    places = [topic.partition("/")[0] for topic in PRESSURES.values()]
    assert sorted(links) == sorted(prefix + name for name in ("base_link", "carriage", *places))
    joints = {joint.get("name"): joint.get("type") for joint in robot.iter("joint")}
    assert joints.pop(f"{prefix}carriage") == "prismatic"
    assert set(joints.values()) == {"fixed"}
    children = [child.get("link") for child in robot.iter("child")]
    assert sorted([*children, f"{prefix}base_link"]) == sorted(links)  # a tree with one root
    assert {parent.get("link") for parent in robot.iter("parent")} == {f"{prefix}base_link"}


def test_the_carriage_stays_between_the_end_caps() -> None:
    """Its body at either end of the stroke touches a cap and no more."""
    robot = urdf(**OTHER)
    (body,) = robot.findall("link[@name='left/carriage']/visual/geometry/box")
    half = 0.5 * float(body.get("size", "").split()[0])
    caps = []
    for visual in robot.findall("link[@name='left/base_link']/visual"):
        box, origin = visual.find("geometry/box"), visual.find("origin")
        if box is not None and origin is not None:
            centre = float(origin.get("xyz", "").split()[0])
            size = float(box.get("size", "").split()[0])
            caps.append((centre - 0.5 * size, centre + 0.5 * size))
    (_, first), (last, _) = caps
    assert first == pytest.approx(-half, abs=1e-6)
    assert last == pytest.approx(0.5 + half, abs=1e-6)


def test_the_mass_is_that_of_the_rig() -> None:
    """A box of m kg: the moment about x is m (y² + z²) / 12."""
    link = urdf(**{"cylinder.moving_mass": 2.0}).find("link[@name='carriage']")
    assert link is not None
    mass, inertia, box = (link.find(f".//{name}") for name in ("mass", "inertia", "box"))
    assert mass is not None
    assert inertia is not None
    assert box is not None
    assert float(mass.get("value", "")) == 2.0
    _, y, z = map(float, box.get("size", "").split())
    expected = 2.0 * math.hypot(y, z) ** 2 / 12.0
    assert float(inertia.get("ixx", "")) == pytest.approx(expected, rel=1e-4)
