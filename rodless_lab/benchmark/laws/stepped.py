# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A run sample by sample, in which the rig changes on the way or readings come late."""

import math
from collections import deque

import numpy as np

from rodless_base.measurement import Measurement
from rodless_control import ReferencePoint
from rodless_control.controller import Law, checked_answer, output_limits
from rodless_control.references import sampled
from rodless_lab.benchmark.laws.tasks import Task
from rodless_lab.simulation.closed_loop import sample_count
from rodless_lab.simulation.run_metrics import RunMetrics, metrics_of
from rodless_sim import Rig, RigParameters
from rodless_sim.timing import nanoseconds, sample_times


def stepped(drawn: RigParameters, law: Law, task: Task) -> RunMetrics:
    """Return the figures of ``law`` at ``task``; raises SimulationError and LawError.

    The air is not counted: NaN.
    """
    period = nanoseconds(task.period, "period")
    count = sample_count(nanoseconds(task.duration), period)
    times = sample_times(count, period)
    wanted = sampled(task.reference, times)
    parameters = task.rig(drawn).with_values({"cylinder.initial_position": task.position})
    rig, changes = Rig(parameters), round(task.at / task.period)
    commands = np.empty((count, 2))
    late: deque[Measurement] = deque(maxlen=task.delay + 1)
    low, high = output_limits(law.parameters)
    law.reset()
    for k, (position, velocity) in enumerate(wanted.tolist()):
        if k == changes and k > 0:
            rig.configure(parameters.with_values(task.changed(parameters)))
        late.append(rig.read())
        reference = ReferencePoint(position, velocity)
        answer = law.update(late[0], reference, task.period if k else 0.0)
        voltage = min(max(checked_answer(law, answer)[0], low), high)
        commands[k] = voltage, rig.motion.position
        rig.advance(voltage, task.period)
    found = metrics_of(times, wanted[:, 0].copy(), np.zeros((count, 2)), 0, commands, task.since)
    return found._replace(air=math.nan)
