# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The runner over ROS: the same runs by the nodes, over topics, in lock-step."""

from collections.abc import Callable, Mapping

import numpy as np
import numpy.typing as npt

from rodless_base.constants import NANOSECONDS_PER_SECOND
from rodless_base.parameters import Value
from rodless_base.ros.parameters import ros_value
from rodless_control import ControllerParameters, PidParameters
from rodless_control.references import Reference, Sine, Step
from rodless_lab.experiments.runner import Runner
from rodless_lab.session.samples import Sample, Samples
from rodless_lab.session.session import RigSession
from rodless_lab.simulation.closed_loop import ClosedLoopTrace
from rodless_sim import RigParameters, Trace
from rodless_sim.rig import applied_voltage
from rodless_sim.timing import nanoseconds, sample_times

Array = npt.NDArray[np.float64]

# For one run of the rig, in wall-clock s: the longest, 44000 samples, takes well under a minute
# on a machine of its own.
RUN_TIMEOUT = 600.0

# What belongs to a run and not to the rig or the controller: the session sets it.
OF_THE_SESSION = (
    "time.mode",
    "time.duration",
    "time.scenario",
    "time.recorders",
    "time.command_timeout",
    "controller.recorders",
)


def nodes_runner(ran: Callable[[], None] = lambda: None) -> Runner:
    """Return a runner whose runs are those of the nodes; ``ran`` is called after each.

    A run's mass flows, which nobody publishes, are NaN, and it has no columns of the rig's options,
    such as temperatures. All else is what the runner in process gives, bit for bit. Runs raise
    RuntimeError, with what the nodes have printed, where a node ends by itself or nothing comes
    from it.
    """
    runs = RosRuns(ran)
    return Runner(runs.open_loop, runs.closed_loop)


class RosRuns:
    """Each run has nodes and a ROS domain of its own."""

    def __init__(self, ran: Callable[[], None]) -> None:
        """Call ``ran`` after each run."""
        self._ran = ran

    def open_loop(
        self,
        parameters: RigParameters,
        voltages: npt.ArrayLike,
        period: float,
        position: float | None = None,
    ) -> Trace:
        """Send voltages (V, shape (n,)) to the plant, one for each sample; see ``OpenLoop``."""
        commands = [applied_voltage(float(voltage)) for voltage in np.ravel(voltages)]
        span = nanoseconds(period)

        def law(sample: Sample) -> float | None:
            index = round(sample.time * NANOSECONDS_PER_SECOND / span)
            return commands[index] if index < len(commands) else None

        duration = len(commands) * span * 1e-9
        plant = plant_values(parameters, period, position)
        with RigSession("lockstep", plant=plant, controller=None, duration=duration) as rig:
            rig.drive(law)
            samples = rig.run(RUN_TIMEOUT)
        self._ran()
        return trace(samples, np.array([*commands, commands[-1]]), span)

    def closed_loop(
        self,
        rig_parameters: RigParameters,
        law: PidParameters | ControllerParameters,
        reference: Reference,
        duration: float,
        period: float,
        position: float | None = None,
    ) -> ClosedLoopTrace:
        """Let plant and controller run for ``duration`` s; see ``ClosedLoop``.

        Raises TypeError for a reference that is neither step nor sine.
        """
        span = nanoseconds(period)
        with RigSession(
            "lockstep",
            plant=plant_values(rig_parameters, period, position),
            controller={**file_values(law), **reference_parameters(reference)},
            duration=round(nanoseconds(duration) / span) * span * 1e-9,
        ) as rig:
            samples = rig.run(RUN_TIMEOUT)
        self._ran()
        run = trace(samples, samples.voltage, span)
        wanted = np.array([reference.sample(k * span * 1e-9)[0] for k in range(len(samples))])
        return ClosedLoopTrace(**run.columns(), reference=wanted, error=wanted - run.position)


def trace(samples: Samples, voltage: Array, period: int) -> Trace:
    """Return what was heard every ``period`` ns, with the voltages (V) held after each sample."""
    unknown = np.full(len(samples), np.nan)
    return Trace(
        time=sample_times(len(samples), period),
        position=samples.position,
        velocity=samples.velocity,
        pressure_a=samples.pressure_a,
        pressure_b=samples.pressure_b,
        voltage=voltage,
        force=samples.force,
        mass_flow_a=unknown,
        mass_flow_b=unknown.copy(),
    )


def plant_values(
    rig: RigParameters, period: float, position: float | None = None
) -> dict[str, object]:
    """Return the plant's parameters: a sample every ``period`` s, from ``position`` (m)."""
    changes: dict[str, object] = {"time.period": period}
    if position is not None:
        changes["cylinder.initial_position"] = position
    return file_values(rig.with_values(changes))


def file_values(parameters: Mapping[str, Value]) -> dict[str, object]:
    """Return parameters as a file takes them, without those of the session."""
    return {
        name: ros_value(value) for name, value in parameters.items() if name not in OF_THE_SESSION
    }


def reference_parameters(reference: Reference) -> dict[str, object]:
    """Return the controller's ``reference.*`` of a step or a sine; raises TypeError for others."""
    if isinstance(reference, Step):
        return {
            "reference.type": "step",
            "reference.start": reference.before,
            "reference.target": reference.after,
            "reference.at": reference.at,
        }
    if isinstance(reference, Sine):
        return {
            "reference.type": "sine",
            "reference.centre": reference.centre,
            "reference.amplitude": reference.amplitude,
            "reference.frequency": reference.frequency,
            "reference.at": reference.at,
        }
    raise TypeError(f"no reference.* parameters for {reference!r}")
