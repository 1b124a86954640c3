"""`rodless drive`: give a rig the voltages that an identification needs, one for each sample."""

import argparse
import sys
from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.utilities import remove_ros_args
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from rodless_base.constants import CLOSED_VOLTAGE
from rodless_base.ros.diagnostics import steady_clock
from rodless_base.ros.process import run_node
from rodless_base.ros.publish import send
from rodless_base.ros.topics import (
    JOINT_STATES,
    LOSSLESS,
    NANOSECONDS,
    QUEUE_DEPTH,
    VALVE_VOLTAGE,
    stamp_nanoseconds,
)
from rodless_base.start import Stop
from rodless_lab.identification.excitation import EXCITATIONS, PERIOD

# How often, in wall-clock s, the driver looks whether it is heard.
POLL_PERIOD = 0.02

# How long the last command may take to arrive.
LAST_WORD = Duration(seconds=1.0)


class Driver:
    """Answers each sample with the voltage that is due ``time`` after the first one."""

    def __init__(
        self, voltages: npt.NDArray[np.float64], recorders: int, ended: Callable[[], None]
    ) -> None:
        """Speak ``voltages`` (V, shape (n,), ``PERIOD`` apart), close the valve, call ``ended``.

        Listens to samples once the rig and ``recorders`` hear it, so that no command is lost.
        """
        self.node = Node("driver")
        self._voltages = voltages
        self._listeners = 1 + recorders
        self._ended = ended
        self._first: int | None = None
        self._said = -1
        self.done = False
        self._publisher = self.node.create_publisher(Float64, VALVE_VOLTAGE, LOSSLESS)
        self._watch = self.node.create_timer(POLL_PERIOD, self._poll, clock=steady_clock())

    def close(self) -> None:
        """Leave the valve closed and destroy the node."""
        if self._publisher.get_subscription_count():
            send(self._publisher, Float64(data=CLOSED_VOLTAGE))
            self._publisher.wait_for_all_acked(LAST_WORD)
        self.node.destroy_node()

    def _poll(self) -> None:
        if self._publisher.get_subscription_count() >= self._listeners:
            self._watch.cancel()
            self.node.create_subscription(JointState, JOINT_STATES, self._answer, QUEUE_DEPTH)

    def _answer(self, sample: JointState) -> None:
        now = stamp_nanoseconds(sample.header.stamp)
        if self._first is None or now < self._first:
            self._first = now
        elapsed = now - self._first
        due = elapsed // round(PERIOD * NANOSECONDS)
        self.done = due >= len(self._voltages)
        if self.done:
            self._ended()
            return
        send(self._publisher, Float64(data=float(self._voltages[due])))
        self._show(elapsed // NANOSECONDS)

    def _show(self, seconds: int) -> None:
        if seconds != self._said and sys.stdout.isatty():
            self._said = seconds
            print(f"\r{seconds} of {len(self._voltages) * PERIOD:.0f} s", end="", flush=True)


def main(arguments: Sequence[str], stop: Stop) -> int:
    """Return 0 once all voltages were given, 1 where it was ended before."""
    options = _parser().parse_args(remove_ros_args(["drive", *arguments])[1:])
    voltages = EXCITATIONS[options.subject]()
    drivers: list[Driver] = []

    def end() -> None:
        stop.requested = True

    def make() -> Driver:
        drivers.append(Driver(voltages, options.recorders, end))
        return drivers[0]

    print(f"{len(voltages) * PERIOD:.1f} s of voltages on {VALVE_VOLTAGE}", flush=True)
    code = run_node(make, stop)
    done = bool(drivers) and drivers[0].done
    print("\rall given, valve closed" if done else "\rended before all voltages were given")
    return code or (0 if done else 1)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="rodless drive",
        description="Drive a rig so that `rodless identify` finds something, the carriage starting "
        "near 60 mm.",
        epilog="Nobody else may command the valve: start the rig without its controller. Record "
        "meanwhile. For a namespace append --ros-args -r __ns:=/NAME.",
    )
    parser.add_argument("subject", choices=sorted(EXCITATIONS))
    parser.add_argument(
        "--recorders",
        type=int,
        default=0,
        metavar="N",
        help="recorders to wait for (%(default)d), so that the first command is in their bags",
    )
    return parser
