# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The rig as URDF, for RViz and for whoever reads ``robot_description``.

Its joint is the one that ``joint_states`` moves, its frames are those that the pressures are
stamped with. Units and axes by REP 103: metres, kilograms, the stroke along x.
"""

import math
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from rodless_base.constants import CARRIAGE, PISTON
from rodless_base.frames import prefixed
from rodless_base.topics import PRESSURE_FRAMES
from rodless_sim.parameters import RigParameters
from rodless_sim.physics.coupling import MAGNETIC

BASE = "base_link"

# SMC catalogue CY3R: rated for 50 to 500 mm/s.
RATED_VELOCITY = 0.5  # m/s

# Outlines drawn, in bores, after the catalogue's drawing of the CY3R25; nothing is computed with
# them.
TUBE_DIAMETER = 1.1
BODY = (2.8, 1.9, 2.1)  # of the carriage: length, width, height
CAP = (1.0, 1.9, 2.1)  # of each end

COLOURS = {"tube": "0.75 0.76 0.78 1", "cap": "0.25 0.26 0.28 1", "body": "0.90 0.55 0.10 1"}


def robot_description(parameters: RigParameters) -> str:
    """Return the rig as URDF.

    Parameters
    ----------
    parameters
        Those of the rig: its stroke limits the joint, bore, supply and moving mass size the rest,
        ``frame_prefix`` comes before the joint's name and all frames, as in the nodes' messages.

    Examples
    --------
    >>> from rodless_sim import RigParameters
    >>> from rodless_sim.description import robot_description
    >>> '<limit lower="0" upper="0.2"' in robot_description(RigParameters())
    True

    """
    bore, stroke = parameters.number("cylinder.bore"), parameters.number("cylinder.stroke")
    frame_prefix = prefixed(parameters, "")
    robot = Element("robot", name=f"{frame_prefix}rodless_rig".replace("/", "_"))
    base = SubElement(robot, "link", name=frame_prefix + BASE)
    # The piston's centre travels from 0 to the stroke; the tube reaches half a body beyond.
    reach = 0.5 * BODY[0] * bore
    tube = SubElement(base, "visual")
    _origin(tube, x=0.5 * stroke, pitch=0.5 * math.pi)
    radius = 0.5 * TUBE_DIAMETER * bore
    _shape(tube, "cylinder", radius=_text(radius), length=_text(stroke + 2.0 * reach))
    _colour(tube, "tube")
    for x in (-reach, stroke + reach):
        cap = SubElement(base, "visual")
        _origin(cap, x=x + math.copysign(0.5 * CAP[0] * bore, x))
        _shape(cap, "box", size=_box(CAP, bore))
        _colour(cap, "cap")
    _carriage(robot, parameters, frame_prefix)
    if parameters.text("coupling.kind") == MAGNETIC:
        _piston(robot, parameters, frame_prefix)
    places = ((-reach, 0.0), (stroke + reach, 0.0), (0.5 * stroke, -2.5 * bore))
    for frame, (x, y) in zip(PRESSURE_FRAMES.values(), places, strict=True):
        SubElement(robot, "link", name=frame_prefix + frame)
        joint = _joint(robot, "fixed", frame_prefix, frame)
        _origin(joint, x=x, y=y)
    ElementTree.indent(robot)
    return '<?xml version="1.0"?>\n' + ElementTree.tostring(robot, encoding="unicode") + "\n"


def _carriage(robot: Element, parameters: RigParameters, prefix: str) -> None:
    bore, mass = parameters.number("cylinder.bore"), parameters.number("cylinder.moving_mass")
    link = SubElement(robot, "link", name=prefix + CARRIAGE)
    body = SubElement(link, "visual")
    _shape(body, "box", size=_box(BODY, bore))
    _colour(body, "body")
    inertial = SubElement(link, "inertial")
    SubElement(inertial, "mass", value=_text(mass))
    x, y, z = (side * bore for side in BODY)
    moments = {
        "ixx": mass * (y * y + z * z) / 12.0,
        "iyy": mass * (x * x + z * z) / 12.0,
        "izz": mass * (x * x + y * y) / 12.0,
    }
    zero = dict.fromkeys(("ixy", "ixz", "iyz"), 0.0)
    SubElement(inertial, "inertia", {name: _text(v) for name, v in {**moments, **zero}.items()})
    _slides(_joint(robot, "prismatic", prefix, CARRIAGE), parameters)


def _piston(robot: Element, parameters: RigParameters, prefix: str) -> None:
    """Add the piston within the tube, where the magnets join it to the carriage."""
    bore = parameters.number("cylinder.bore")
    visual = SubElement(SubElement(robot, "link", name=prefix + PISTON), "visual")
    _origin(visual, pitch=0.5 * math.pi)
    _shape(visual, "cylinder", radius=_text(0.5 * bore), length=_text(bore))
    _colour(visual, "cap")
    _slides(_joint(robot, "prismatic", prefix, PISTON), parameters)


def _slides(joint: Element, parameters: RigParameters) -> None:
    """Let a joint move along the stroke."""
    bore = parameters.number("cylinder.bore")
    SubElement(joint, "axis", xyz="1 0 0")
    gauge = parameters.number("supply.pressure") - parameters.number("atmosphere.pressure")
    SubElement(
        joint,
        "limit",
        lower="0",
        upper=repr(parameters.number("cylinder.stroke")),
        effort=_text(0.25 * math.pi * bore * bore * gauge),
        velocity=_text(RATED_VELOCITY),
    )


def _joint(robot: Element, kind: str, prefix: str, child: str) -> Element:
    """Add the joint that holds ``child`` on the base; it is named like its child."""
    joint = SubElement(robot, "joint", name=prefix + child, type=kind)
    SubElement(joint, "parent", link=prefix + BASE)
    SubElement(joint, "child", link=prefix + child)
    return joint


def _origin(parent: Element, x: float = 0.0, y: float = 0.0, pitch: float = 0.0) -> None:
    SubElement(parent, "origin", xyz=f"{_text(x)} {_text(y)} 0", rpy=f"0 {_text(pitch)} 0")


def _box(sides: tuple[float, float, float], bore: float) -> str:
    return " ".join(_text(side * bore) for side in sides)


def _text(number: float) -> str:
    return f"{number:.6g}"


def _shape(visual: Element, kind: str, **sizes: str) -> None:
    SubElement(SubElement(visual, "geometry"), kind, sizes)


def _colour(visual: Element, name: str) -> None:
    material = SubElement(visual, "material", name=name)
    SubElement(material, "color", rgba=COLOURS[name])
