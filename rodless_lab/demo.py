"""`rodless demo`: both nodes over DDS move the carriage 0 -> 58 mm; a bag, a table, a picture."""

import argparse
import json
import os
import shutil
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import rclpy
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from rodless_base.parameter_file import preset_names
from rodless_base.ros.process import leave_ros, make_executor
from rodless_base.ros.topics import JOINT_STATES, QUEUE_DEPTH, VALVE_VOLTAGE
from rodless_base.start import Stop
from rodless_lab.bags.reader import Bag, read_bag
from rodless_lab.bags.ros.recorder import Recorder
from rodless_lab.bags.writer import BagWriter
from rodless_lab.figures.step import save_step_picture
from rodless_lab.runs.step_metrics import SETTLING_BAND, StepMetrics, step_metrics
from rodless_lab.session.domain import own_domain
from rodless_lab.session.processes import RigProcesses

TARGET = 0.058
SUPPLY_PRESSURE = 0.52e6 + 101325.0
TOPICS = (
    JOINT_STATES,
    "chamber_a/pressure",
    "chamber_b/pressure",
    "supply/pressure",
    VALVE_VOLTAGE,
    "setpoint",
)

# Plant time recorded before the step and after it, in s.
LEAD = 0.5
RUN = 5.5

# Longest wait, in wall-clock s, for the nodes to appear (the first start compiles them) and for
# the run itself on a machine that cannot keep up.
START_TIMEOUT = 120.0
RUN_TIMEOUT = 120.0


class InterruptedRunError(Exception):
    """The user has asked to stop."""


def main(arguments: Sequence[str], stop: Stop) -> int:
    """Return 0 if the carriage ends within 0.2 mm of the target."""
    parser = argparse.ArgumentParser(prog="rodless demo", description=__doc__)
    parser.add_argument("--preset", default="paper", choices=preset_names())
    parser.add_argument("--output", type=Path, default=Path("results/demo"), help="folder")
    options = parser.parse_args(arguments)
    bag = options.output / "bag"
    shutil.rmtree(bag, ignore_errors=True)
    stop.from_now_on_wait()
    try:
        drive(options.preset, bag, stop)
    except InterruptedRunError:
        print(f"\ninterrupted; what was recorded is in {bag}")
        return 0
    except (RuntimeError, TimeoutError) as error:
        print(f"\n{error}", file=sys.stderr)
        return 1
    return report(options.preset, read_bag(bag), options.output)


def drive(preset: str, bag: Path, stop: Stop) -> None:
    """Start the nodes in a domain of their own, make the move, record it into ``bag``."""
    with own_domain() as environment:
        os.environ.update(environment)
        print("starting plant and controller (the first start compiles them)", flush=True)
        with RigProcesses(
            preset, plant={"supply.pressure": SUPPLY_PRESSURE}, environment=environment
        ) as rig:
            rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
            try:
                with BagWriter(bag) as writer:
                    Move(writer, rig, stop).make()
            finally:
                leave_ros()


class Move:
    """One recorded move, seen from a node of its own."""

    def __init__(self, writer: BagWriter, rig: RigProcesses, stop: Stop) -> None:
        """Make the node and its executor."""
        self._rig = rig
        self._stop = stop
        self._node: Node = rclpy.create_node("demo")
        self._setpoint = self._node.create_publisher(Float64, "setpoint", 10)
        self._node.create_subscription(JointState, JOINT_STATES, self._take, QUEUE_DEPTH)
        self._writer = writer
        self._executor: Executor = make_executor()
        self._executor.add_node(self._node)
        self._time = 0.0
        self._position = 0.0

    def make(self) -> None:
        """Wait for everybody, step, follow the carriage to the end of the run."""
        try:
            # The recorder comes after the plant: it takes its times from the plant's clock.
            self._wait(lambda: self._time > 0.0, START_TIMEOUT, "the plant did not start")
            recorder = Recorder(self._writer, TOPICS)
            self._executor.add_node(recorder.node)
            try:
                self._step(recorder)
            finally:
                self._executor.remove_node(recorder.node)
                recorder.close()
        finally:
            self._executor.remove_node(self._node)
            self._node.destroy_node()

    def _step(self, recorder: Recorder) -> None:
        def everybody_listens() -> bool:
            listeners = 2  # the controller and the recorder
            return recorder.ready and self._setpoint.get_subscription_count() == listeners

        self._wait(everybody_listens, START_TIMEOUT, "the controller did not start")
        start = self._time
        self._wait(lambda: self._time > start + LEAD, RUN_TIMEOUT, "the plant stands still")
        print(f"moving to {TARGET * 1e3:g} mm", flush=True)
        self._setpoint.publish(Float64(data=TARGET))
        end = self._time + RUN
        self._wait(
            lambda: self._time > end,
            RUN_TIMEOUT,
            "the plant stands still",
            lambda: show_progress(1.0 - (end - self._time) / RUN, self._position),
        )
        show_progress(1.0, self._position)

    def _take(self, message: JointState) -> None:
        self._time = message.header.stamp.sec + message.header.stamp.nanosec * 1e-9
        self._position = message.position[0]

    def _wait(
        self,
        done: Callable[[], bool],
        timeout: float,
        complaint: str,
        show: Callable[[], None] = lambda: None,
    ) -> None:
        """Run callbacks until ``done``; raises TimeoutError with ``complaint``."""
        end = time.monotonic() + timeout
        shown = 0.0
        while not done():
            self._executor.spin_once(timeout_sec=0.1)
            if self._stop.requested:
                raise InterruptedRunError
            now = time.monotonic()
            if now > end:
                raise TimeoutError(complaint)
            if now > shown + 0.1:
                self._rig.check()
                show()
                shown = now


def show_progress(share: float, position: float) -> None:
    """Show how far the run is: on a terminal a line that is written over, elsewhere nothing."""
    if sys.stdout.isatty():
        bar = "#" * round(30 * share)
        end = "\n" if share == 1.0 else ""
        print(f"\r[{bar:30}] carriage at {position * 1e3:7.3f} mm", end=end, flush=True)


@dataclass(frozen=True)
class Outcome:
    """What the bag says of the run."""

    metrics: StepMetrics
    supply_pressure: float


def measure(bag: Bag) -> Outcome:
    """Measure the move from what the topics carried."""
    joint = bag[f"/{JOINT_STATES}"]
    metrics = step_metrics(
        joint.stamp,
        joint.fields["position"][:, 0],
        bag[f"/{VALVE_VOLTAGE}"].fields["data"],
        start=0.0,
        target=TARGET,
        at=bag["/setpoint"].time[0],
    )
    return Outcome(metrics, float(bag["/supply/pressure"].fields["fluid_pressure"][-1]))


def report(preset: str, bag: Bag, folder: Path) -> int:
    """Print and write what ``bag`` holds; return the exit code."""
    outcome = measure(bag)
    metrics = outcome.metrics
    gauge = outcome.supply_pressure - 101325.0
    print(f"{'preset':28}{preset:>12}")
    for label, value, unit in (
        ("rise time 10-90 %", metrics.rise_time, "s"),
        ("settling time to ±0.2 mm", metrics.settling_time, "s"),
        ("overshoot", metrics.overshoot * 1e3, "mm"),
        ("final error", metrics.final_error * 1e3, "mm"),
        ("peak valve voltage", metrics.peak_voltage, "V"),
        ("supply pressure, gauge", gauge * 1e-6, "MPa"),
    ):
        print(f"{label:28}{value:12.3f} {unit}")
    folder.mkdir(parents=True, exist_ok=True)
    values = {**vars(metrics), "supply_pressure": outcome.supply_pressure, "preset": preset}
    (folder / "metrics.json").write_text(json.dumps(values, indent=2) + "\n", encoding="utf-8")
    draw(preset, bag, folder / "step.png")
    print(f"bag, metrics.json and step.png are in {folder}")
    if abs(metrics.final_error) > SETTLING_BAND:
        print("the final error exceeds 0.2 mm", file=sys.stderr)
        return 1
    return 0


def draw(preset: str, bag: Bag, path: Path) -> None:
    """Draw position, pressures and voltage of the run."""
    joint, command, setpoint = (
        bag[f"/{topic}"] for topic in (JOINT_STATES, VALVE_VOLTAGE, "setpoint")
    )
    at = setpoint.time[0]
    save_step_picture(
        path,
        f"0 to 58 mm over ROS topics, preset {preset}",
        position=(joint.stamp, joint.fields["position"][:, 0]),
        reference=([joint.stamp[0], at, at, joint.stamp[-1]], [0.0, 0.0, TARGET, TARGET]),
        pressures={
            f"chamber {name.upper()}": (
                bag[f"/chamber_{name}/pressure"].stamp,
                bag[f"/chamber_{name}/pressure"].fields["fluid_pressure"],
            )
            for name in ("a", "b")
        },
        voltage=(command.time, command.fields["data"]),
    )
