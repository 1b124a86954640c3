# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What a node says of itself on ``/diagnostics``: level, message, values, faults of late."""

from collections.abc import Callable, Mapping, Sequence

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.publisher import Publisher

from rodless_base.fault_counts import FaultCounts
from rodless_base.ros.guarded_node import CALLBACK_ERRORS, GuardedNode
from rodless_base.ros.namesakes import Namesakes
from rodless_base.ros.topics import set_stamp

OK: bytes = DiagnosticStatus.OK
WARN: bytes = DiagnosticStatus.WARN
ERROR: bytes = DiagnosticStatus.ERROR

DIAGNOSTICS = "/diagnostics"

# Period of /diagnostics in wall-clock seconds, the convention of ROS.
PERIOD = 1.0

# Keys of the plant's diagnostic that the controller goes by too: see PlantReport. The rate is named
# as in the FrequencyStatus of diagnostic_updater: samples due per wall-clock s, 0 while none is.
MODE, PRESET, TARGET_RATE = "mode", "preset", "Target frequency (Hz)"
ACTUAL_RATE = "Actual frequency (Hz)"

# What the plant's gauge pressures count from.
ATMOSPHERE = "atmosphere (Pa)"

# Which nodes the plant sees publish commands, by their full names: one that is frozen is known to
# whom it has met, and to nobody who comes later.
COMMANDED_BY = "commanded by"

# How many the plant sends its samples to.
SUBSCRIBERS = "subscribers of joint_states"

# Of the controller's: whose the last command was, which has telemetry where it was the law's.
LAST_COMMAND = "last command"
OF_THE_LAW, CLOSED_VALVE = "of the law", "closed valve"

# Whether the controller is: its message may say what is wrong with it besides.
ENABLED = "enabled"

# How many nodes have the name of the one that reports, itself included.
NAMESAKES = "nodes of this name"


class Diagnostics:
    """Publishes the state of one node, with its faults and its namesakes."""

    def __init__(self, node: GuardedNode, faults: Callable[[], dict[str, int]]) -> None:
        """Count the ``faults`` since the start: how often each has happened, never falling."""
        self._node = node
        self._publisher = diagnostics_publisher(node)
        self._faults = faults
        self._counts = FaultCounts()
        self.namesakes = Namesakes(node)

    def clear(self) -> None:
        """Count faults from now on."""
        self._counts.clear(self._totals())

    def count(self) -> dict[str, int]:
        """Count namesakes, and faults up to now; return the faults since the last clear."""
        self.namesakes.check()
        return self._counts.update(self._totals())

    def lately(self) -> dict[str, int]:
        """Return the faults of the seconds before the last count."""
        return self._counts.lately()

    def _totals(self) -> dict[str, int]:
        return {**self._faults(), CALLBACK_ERRORS: self._node.callback_errors}

    def publish(
        self,
        nanoseconds: int,
        judgement: tuple[bytes, str],
        values: Mapping[str, object],
        hardware: Sequence[str] = (),
        parts: Sequence[DiagnosticStatus] = (),
    ) -> None:
        """Publish level and message of ``judgement`` with ``values`` in words, then ``parts``.

        ``nanoseconds`` is plant time. The hardware is the rig, by its namespace, and what
        ``hardware`` adds to that.
        """
        values = {**values, NAMESAKES: self.namesakes.count}
        own = status(self._node, judgement, values, hardware)
        self._publisher.publish(report([own, *parts], nanoseconds))


def status(
    node: Node,
    judgement: tuple[bytes, str],
    values: Mapping[str, object],
    hardware: Sequence[str] = (),
    part: str = "",
) -> DiagnosticStatus:
    """Return what to report of ``node``, or of the ``part`` of it that is named."""
    level, message = judgement
    rig = f"rig{node.get_namespace()}".rstrip("/")
    return DiagnosticStatus(
        level=level,
        name=node.get_fully_qualified_name() + (f": {part}" if part else ""),
        message=message,
        hardware_id=", ".join([rig, *hardware]),
        values=[KeyValue(key=key, value=str(value)) for key, value in values.items()],
    )


def report(statuses: Sequence[DiagnosticStatus], nanoseconds: int) -> DiagnosticArray:
    """Return the message of ``statuses`` at a plant time (ns)."""
    message = DiagnosticArray(status=list(statuses))
    set_stamp(message.header.stamp, nanoseconds)
    return message


def judge(
    problem: str | None, state: str | None, warnings: Sequence[str | None], well: str
) -> tuple[bytes, str]:
    """Return level and message: an error now, a warning for now or for faults of late, or all well.

    ``state`` is what the node does by request, if anything; warnings that are None do not count.
    """
    if problem is not None:
        return ERROR, problem
    found = [warning for warning in warnings if warning is not None]
    said = [state, *found] if state is not None else found
    return (WARN if found else OK), "; ".join(said) or well


def steady_clock() -> Clock:
    """Wall-clock time that neither jumps nor follows the simulation."""
    return Clock(clock_type=ClockType.STEADY_TIME)


def diagnostics_publisher(node: Node) -> Publisher:
    """Return a publisher on the topic where tools look for diagnostics."""
    return node.create_publisher(DiagnosticArray, DIAGNOSTICS, 10)
