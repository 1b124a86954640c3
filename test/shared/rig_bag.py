# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Bags of the rig's topics, written message by message so that each can be spoilt."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from builtin_interfaces.msg import Time
from rclpy.serialization import serialize_message
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Float64, Float64MultiArray, Header

from rodless_base.constants import CLOSED_VOLTAGE
from rodless_lab.bags.metadata import BagTopic
from rodless_lab.bags.reader import read_bag
from rodless_lab.bags.writer import BagWriter
from rodless_lab.runs.measured_run import MeasuredRun

PRESSURES = {
    "/chamber_a/pressure": "pressure_a",
    "/chamber_b/pressure": "pressure_b",
    "/supply/pressure": "supply_pressure",
}

ARRAYS = "std_msgs/msg/Float64MultiArray"

# Topic, sample, time in s, value: what is written instead, or None for nothing.
Message = tuple[float, float]
Spoil = Callable[[str, int, float, float], Message | None]


def untouched(_topic: str, _sample: int, time: float, value: float) -> Message | None:
    return time, value


def payload(topic: str, time: float, value: float, origin: int = 0) -> bytes:
    nanoseconds = origin + round(time * 1e9)
    header = Header(stamp=Time(sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9))
    if topic == "/joint_states":
        return serialize_message(JointState(header=header, name=["carriage"], position=[value]))
    if topic == "/valve/state":
        return serialize_message(JointState(header=header, name=["valve_spool"], effort=[value]))
    if topic in PRESSURES:
        return serialize_message(FluidPressure(header=header, fluid_pressure=value))
    return serialize_message(Float64(data=value))


def write(
    path: Path,
    run: MeasuredRun,
    spoil: Spoil = untouched,
    without: str = "",
    setpoint: tuple[float, float] | None = None,
    clock: Callable[[float], float] = lambda time: time,
    held: bool = False,
    origin: int = 0,
) -> Path:
    """Write ``run`` as a bag; a set-point is (time in s, m), ``clock`` the log time of a time.

    ``held`` adds what the valve held. Times are from ``origin`` (ns) on.
    """
    columns = {"/joint_states": run.position, "/valve/voltage": run.voltage}
    columns |= {topic: getattr(run, name) for topic, name in PRESSURES.items()}
    if held:
        columns["/valve/state"] = np.append(CLOSED_VOLTAGE, run.voltage[:-1])
    types = dict.fromkeys(("/joint_states", "/valve/state"), "JointState")
    types |= {"/valve/voltage": "Float64", "/setpoint": "Float64"}
    with BagWriter(path) as writer:
        for topic in [*columns, *(["/setpoint"] if setpoint else [])]:
            if topic != without:
                kind = types.get(topic, "FluidPressure")
                package = "std_msgs" if kind == "Float64" else "sensor_msgs"
                writer.add_topic(BagTopic(topic, f"{package}/msg/{kind}"))
        for k, time in enumerate(run.time.tolist()):
            for topic, values in columns.items():
                message = spoil(topic, k, time, float(values[k]))
                if topic != without and message is not None:
                    log_time = origin + round(clock(message[0]) * 1e9)
                    writer.write(topic, payload(topic, *message, origin), log_time, log_time)
        if setpoint is not None:
            log_time = origin + round(clock(setpoint[0]) * 1e9)
            writer.write("/setpoint", payload("/setpoint", *setpoint), log_time, log_time)
    return path


def with_arrays(path: Path, run: MeasuredRun, topic: str, numbers: list[list[float]]) -> Path:
    """Write a run in which a topic of single numbers has arrays of them instead."""
    times = run.time.tolist()
    write(path / "plain", run, without=topic, held=True)
    plain = read_bag(path / "plain")
    with BagWriter(path / "bag") as writer:
        for name in plain:
            writer.add_topic(plain[name].topic)
            for when, data in zip(plain[name].log_time, plain[name].payloads, strict=True):
                writer.write(name, data, int(when), int(when))
        writer.add_topic(BagTopic(topic, ARRAYS))
        for k, one in enumerate(numbers):
            when = round(times[k] * 1e9)
            writer.write(topic, serialize_message(Float64MultiArray(data=one)), when, when)
    return path / "bag"
