# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""When the converter takes its samples, and how late their readings come.

A reading at plant time t is of t - ``sensors.delay``; where ``sensors.sampling_period`` is given,
of the last multiple of that before it, and it is held until the next.
"""

from collections import deque

from rodless_base.constants import NANOSECONDS_PER_SECOND
from rodless_base.measurement import Measurement
from rodless_base.parameters import Parameter, ParameterSet, declare
from rodless_sim.physics.sources import JUDGEMENT

PARAMETERS = declare(
    Parameter(
        "sensors.delay",
        0.0,
        "s",
        "time from what the instruments show to the reading of it: conversion and transfer",
        f"{JUDGEMENT}: 1 ms of a card on USB",
        0.0,
        0.1,
    ),
    Parameter(
        "sensors.sampling_period",
        0.0,
        "s",
        "time between the converter's samples, each held until the next; 0 for one at each reading",
        f"{JUDGEMENT}: 5 ms at 200 Hz",
        0.0,
        1.0,
    ),
    Parameter(
        "sensors.publish_truth",
        False,
        "",
        "publish what is true beside what is read, on truth/joint_states and truth/.../pressure",
        "interface",
        fixed=True,
        in_runs=False,
    ),
    Parameter(
        "sensors.publish_raw",
        False,
        "",
        "publish the voltages that the converter reads of the instruments, on raw/voltages",
        "interface",
        fixed=True,
        in_runs=False,
    ),
)


class Acquisition:
    """The instants that readings are of, and what was true then."""

    def __init__(self, parameters: ParameterSet) -> None:
        """Take the delay and the sampling period of ``parameters``."""
        self.start()
        self.configure(parameters)

    def configure(self, parameters: ParameterSet) -> None:
        """Change delay and sampling period."""
        self._delay = round(parameters.number("sensors.delay") * NANOSECONDS_PER_SECOND)
        period = parameters.number("sensors.sampling_period")
        self._period = round(period * NANOSECONDS_PER_SECOND)
        self.at_once = self._delay == self._period == 0
        if self.at_once:
            self.start()  # what is true from now on is not kept

    def start(self) -> None:
        """Forget what was true."""
        self._known: deque[Measurement] = deque()

    def sampled(self, true: Measurement) -> Measurement:
        """Return what was true at the instant that a reading at ``true.stamp`` is of.

        Between two known instants it is on the line through both; before the first it is as then.
        """
        if not self._known or self._known[-1].stamp != true.stamp:
            self._known.append(true)
        instant = true.stamp - self._delay
        if self._period:
            instant -= instant % self._period
        while len(self._known) > 1 and self._known[1].stamp <= instant:
            self._known.popleft()
        first = self._known[0]
        if len(self._known) == 1 or instant <= first.stamp:
            return first._replace(stamp=instant)
        then = self._known[1]
        share = (instant - first.stamp) / (then.stamp - first.stamp)
        values = (a + share * (b - a) for a, b in zip(first[1:], then[1:], strict=True))
        return Measurement(instant, *values)
