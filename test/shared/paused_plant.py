# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A running plant taken step by step, so that its answers can be foretold to the last digit."""

from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Float64
from std_srvs.srv import SetBool, Trigger

from rodless_base.ros.topics import stamp_nanoseconds
from rodless_lab.session.diagnostic import Diagnostic
from rodless_lab.session.observer import Observer


class PausedPlant:
    """Commands that are known to have arrived, and steps of one period each."""

    def __init__(self, observer: Observer, name: str = "/plant") -> None:
        """Pause the plant of full name ``name``; nobody else may command it."""
        self.observer, self.name = observer, name
        namespace = name.rsplit("/", 1)[0]
        self.samples = observer.collect(JointState, f"{namespace}/joint_states")
        self.pressures = observer.collect(FluidPressure, f"{namespace}/chamber_a/pressure")
        self._command = observer.publisher(Float64, f"{namespace}/valve/voltage")
        self.pause(True)
        self.diagnostic()
        self._received = self.count("commands received")

    def pause(self, paused: bool) -> None:
        """Stop plant time, or let it run."""
        assert self.observer.call(SetBool, f"{self.name}/pause", data=paused).success

    def diagnostic(self) -> Diagnostic:
        """Return a diagnostic that was sent after now; it takes up to a second of wall clock."""
        return self.observer.diagnostic(self.name, fresh=True)

    def last_diagnostic(self) -> Diagnostic:
        """Return the last diagnostic, which is not older than the last command."""
        return self.observer.diagnostic(self.name)

    def count(self, key: str) -> float:
        """Return a number from the last diagnostic."""
        return self.observer.counter(self.name, key)

    def reset(self) -> JointState:
        """Return to the start; return sample 0."""
        start = len(self.samples)
        assert self.observer.call(Trigger, f"{self.name}/reset").success
        self.observer.wait(
            lambda: any(stamp_nanoseconds(s.header.stamp) == 0 for s in self.samples[start:]),
            "sample 0",
        )
        return self.samples[-1]

    def send(self, voltage: float) -> None:
        """Send a command."""
        self._received += 1
        self._command.publish(Float64(data=voltage))

    def command(self, voltage: float) -> None:
        """Send a command and wait until the plant has counted it."""
        self.send(voltage)
        self.observer.wait(
            lambda: self.count("commands received") == self._received,
            f"the plant to receive {voltage} V",
        )

    def steps(self, count: int) -> list[JointState]:
        """Take steps one by one and return the sample of each."""
        start = len(self.samples)
        for _ in range(count):
            assert self.observer.call(Trigger, f"{self.name}/step").success
        self.observer.wait(lambda: len(self.samples) >= start + count, "the samples of the steps")
        return self.samples[start:]


def positions(samples: list[JointState]) -> list[float]:
    """Return the carriage's position in each sample."""
    return [sample.position[0] for sample in samples]
