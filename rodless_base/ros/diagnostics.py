"""One diagnostic status as a ROS message."""

from collections.abc import Mapping

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.publisher import Publisher
from std_msgs.msg import Header

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


def diagnostic(
    node: Node,
    stamp: Time,
    level: bytes,
    message: str,
    values: Mapping[str, object],
    hardware: str = "",
) -> DiagnosticArray:
    """Return the state of ``node`` at ``stamp`` with ``values`` in words.

    The hardware is the rig, by its namespace, and what ``hardware`` adds to that.
    """
    status = DiagnosticStatus(
        level=level,
        name=node.get_fully_qualified_name(),
        message=message,
        hardware_id=f"rig{node.get_namespace()}".rstrip("/")
        + (f", {hardware}" if hardware else ""),
        values=[KeyValue(key=key, value=str(value)) for key, value in values.items()],
    )
    return DiagnosticArray(header=Header(stamp=stamp), status=[status])


def steady_clock() -> Clock:
    """Wall-clock time that neither jumps nor follows the simulation."""
    return Clock(clock_type=ClockType.STEADY_TIME)


def diagnostics_publisher(node: Node) -> Publisher:
    """Return a publisher on the topic where tools look for diagnostics."""
    return node.create_publisher(DiagnosticArray, DIAGNOSTICS, 10)
