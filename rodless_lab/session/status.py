# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""How a running rig is: what its nodes say of themselves, and what its topics carry now."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import isfinite
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Float64

from rodless_base.constants import NANOSECONDS_PER_SECOND, STANDARD_ATMOSPHERE
from rodless_base.ros.diagnostics import ATMOSPHERE
from rodless_base.ros.joint import carriage_position
from rodless_base.ros.topics import stamp_nanoseconds
from rodless_base.topics import JOINT_STATES, PRESSURES, REFERENCE, THROTTLED, VALVE_VOLTAGE
from rodless_lab.session.diagnostic import number_among
from rodless_lab.session.running_rig import CONTROLLER, NODES, PLANT, SILENT, RunningRig

# How long to wait for readings once the nodes have reported, in wall-clock s: Fast DDS may take 3 s
# to match a topic. Of a plant that stands still none may come.
READINGS_TIMEOUT = 4.0
STANDING_TIMEOUT = 0.5

LEVELS = {
    DiagnosticStatus.OK: "OK",
    DiagnosticStatus.WARN: "WARN",
    DiagnosticStatus.ERROR: "ERROR",
    DiagnosticStatus.STALE: "STALE",
}

READINGS = {
    "time": "s, plant time",
    "position": "m",
    "pressure_a": "Pa, absolute",
    "pressure_b": "Pa, absolute",
    "supply_pressure": "Pa, absolute",
    "voltage": "V",
    "reference": "m",
}

# Those that the controller sends; the plant sends the others.
OF_CONTROLLER = {"voltage", "reference"}


@dataclass(frozen=True)
class NodeStatus:
    """What a node says of itself; ``level`` is OK, WARN, ERROR, or missing."""

    level: str
    message: str
    values: dict[str, str]


@dataclass(frozen=True)
class RigStatus:
    """A rig at one moment; a reading is None where nothing came.

    ``readings`` has the names of ``READINGS``, in those units. ``problems`` are those of the rig as
    a whole, a line each.
    """

    namespace: str
    nodes: dict[str, NodeStatus]
    readings: dict[str, float | None]
    problems: tuple[str, ...] = ()

    @property
    def is_well(self) -> bool:
        """Whether both nodes are there, once each, and none reports an error."""
        return not self.problems and all(
            node.level in ("OK", "WARN") for node in self.nodes.values()
        )

    @property
    def is_paused(self) -> bool:
        """Whether the plant stands still by request."""
        return self.nodes[PLANT].values.get("paused") == "True"

    @property
    def has_ended(self) -> bool:
        """Whether the plant stands still because its ``time.duration`` is over."""
        return self.nodes[PLANT].message.startswith("ended")

    @property
    def atmosphere(self) -> float:
        """What gauge pressures count from (Pa): the standard one for a plant that does not say."""
        return number_among(self.nodes[PLANT].values, ATMOSPHERE, STANDARD_ATMOSPHERE)

    @property
    def is_running(self) -> bool:
        """Whether plant time advances."""
        speed = number_among(self.nodes[PLANT].values, "speed factor", 0.0)
        return not self.is_paused and speed > 0.0


def rig_status(rig: RunningRig, timeout: float) -> RigStatus:
    """Listen until both nodes have reported, at most ``timeout`` s, and return what came."""
    readings: dict[str, float | None] = dict.fromkeys(READINGS)
    _listen(rig, readings)
    rig.wait_for(lambda: rig.diagnostic(PLANT) and rig.diagnostic(CONTROLLER), timeout)
    nodes = {node: _node_status(rig, node) for node in NODES}
    status = RigStatus(rig.namespace, nodes, readings, tuple(rig.doubles()))
    stands = status.is_paused or status.has_ended
    if stands:
        # It sends nothing more, but shows whoever comes where it stands.
        _listen(rig, readings, THROTTLED)
    due = _due(status) - ({"voltage"} if stands else set())
    rest = READINGS_TIMEOUT if stands or status.is_running else STANDING_TIMEOUT
    rig.wait_for(lambda: all(readings[one] is not None for one in due), min(timeout, rest))
    elsewhere = rig.samples_elsewhere() if readings["position"] is None else None
    # A sensor that is gone says NaN.
    there = {name: one if one is None or isfinite(one) else None for name, one in readings.items()}
    status = replace(status, readings=there)
    return status if elsewhere is None else replace(status, problems=(*status.problems, elsewhere))


def _due(status: RigStatus) -> set[str]:
    """Return the readings that may still come: of a node that has not reported none will."""
    sent = {PLANT: READINGS.keys() - OF_CONTROLLER, CONTROLLER: OF_CONTROLLER}
    return {one for node in NODES if status.nodes[node].level != "missing" for one in sent[node]}


def _listen(rig: RunningRig, readings: dict[str, float | None], before: str = "") -> None:
    """Keep what comes on the topics, or on those with ``before`` in front: commands have none."""

    def take(name: str, value: Callable[[Any], float]) -> Callable[[Any], None]:
        def taken(message: Any) -> None:
            readings[name] = value(message)

        return taken

    def sample(message: JointState) -> None:
        readings["time"] = stamp_nanoseconds(message.header.stamp) / NANOSECONDS_PER_SECOND
        readings["position"] = carriage_position(message)

    observer = rig.observer
    for field, topic in PRESSURES.items():
        pressure = take(field, lambda message: message.fluid_pressure)
        observer.subscribe(FluidPressure, before + topic, pressure)
    values = {"reference": REFERENCE} | ({} if before else {"voltage": VALVE_VOLTAGE})
    for name, topic in values.items():
        observer.subscribe(Float64, before + topic, take(name, lambda message: message.data))
    observer.subscribe(JointState, before + JOINT_STATES, sample)


def _node_status(rig: RunningRig, node: str) -> NodeStatus:
    said = rig.diagnostic(node)
    if said is None:
        return NodeStatus("missing", SILENT[node] if rig.is_known(node) else "not found", {})
    return NodeStatus(LEVELS.get(said.level, "ERROR"), said.message, dict(said.values))
