# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A recorded run once more, by a simulated rig."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np

from rodless_base.constants import SECONDS_PER_NANOSECOND
from rodless_base.one_line import described
from rodless_control import PidParameters
from rodless_lab.runs.measured_run import MeasuredRun, RunError, Setpoint, run_of_trace
from rodless_lab.runs.off_any_rig import off_any_rig
from rodless_lab.runs.recorded_drive import RecordedDrive, recorded_drive
from rodless_lab.simulation.closed_loop import closed_loop
from rodless_sim import RigParameters, SimulationError, simulate
from rodless_sim.timing import step_nanoseconds

# m, which instruments may place a carriage beyond the end of its stroke without a remark.
FARTHEST_OFF = 1e-3

# Pa, by which chambers may start apart without a remark: the sensors' biases and a valve that is
# closed a little elsewhere make some of it, a carriage that moves or was pushed far more.
FARTHEST_APART = 2e4


def start_of(rig: RigParameters, recorded: MeasuredRun) -> float:
    """Return where the carriage starts (m): as recorded, on the stroke of the rig."""
    return float(np.clip(recorded.position[0], 0.0, rig.number("cylinder.stroke")))


def resimulate(
    parameters: RigParameters,
    recorded: MeasuredRun,
    pressures: tuple[float, float] | None = None,
) -> MeasuredRun:
    """Feed the recorded voltages to a rig at rest where the recorded one starts.

    Its supply is the recorded one. What of ``parameters`` acts on the supply before it is read, or
    on the command before the recorded voltage, is off, and a remark says so.

    ``pressures`` (Pa) are what the chambers start with, as :func:`rodless_sim.simulate` takes them.
    Raises RunError where the recorded voltages are in doubt or no simulated rig can repeat the run.
    """
    recorded.check_voltage()
    with _refusing():
        drive = recorded_drive(parameters, recorded)
        start = start_of(drive.rig, recorded)
        voltages, period = recorded.voltage[:-1], recorded.period
        trace = simulate(drive.rig, voltages, period, start, pressures, scenario=drive.scenario)
    run = run_of_trace(trace, drive.supply)
    apart = _pressures_remark(recorded, run) if pressures is None else ""
    remarks = _remarks(recorded, start, drive, apart)
    # The last voltage acts on nothing in the run, and is the recorded one all the same.
    return replace(run, voltage=recorded.voltage, remarks=remarks)


def replay(parameters: RigParameters, recorded: MeasuredRun) -> MeasuredRun:
    """Feed the recorded voltages to a rig that also starts at the recorded pressures."""
    pressures = (float(recorded.pressure_a[0]), float(recorded.pressure_b[0]))
    return resimulate(parameters, recorded, pressures)


def follow(preset: str, recorded: MeasuredRun, setpoint: Setpoint) -> MeasuredRun:
    """Give the recorded set-points to rig and controller of ``preset``.

    The rig is at rest where the recorded one starts, and has the recorded supply. Raises RunError
    where no simulated rig can follow them.
    """
    with _refusing():
        drive = recorded_drive(RigParameters.preset(preset), recorded)
        start = start_of(drive.rig, recorded)
        # In whole nanoseconds: over a million samples the difference is one of them.
        period = step_nanoseconds(recorded.period) * SECONDS_PER_NANOSECOND
        trace = closed_loop(
            drive.rig,
            PidParameters.preset(preset),
            _Steps(setpoint, start),
            duration=(len(recorded.time) - 1) * period,
            period=period,
            position=start,
            scenario=drive.scenario,
        )
    run = run_of_trace(trace, drive.supply)
    return replace(run, remarks=_remarks(recorded, start, drive, _pressures_remark(recorded, run)))


@contextmanager
def _refusing() -> Iterator[None]:
    """Turn what a rig refuses into a RunError."""
    try:
        yield
    except (ValueError, SimulationError) as error:
        raise RunError(f"no simulated rig can repeat it: {described(error)}") from error


def _remarks(
    recorded: MeasuredRun, start: float, drive: RecordedDrive, apart: str
) -> tuple[str, ...]:
    """Say what of the simulated rig is not as its parameters, or as the recording, have it."""
    return tuple(filter(None, (drive.remark, _start_remark(recorded, start), apart)))


def _start_remark(recorded: MeasuredRun, start: float) -> str:
    """Say where the simulated carriage had to start elsewhere than the recorded one."""
    first = float(recorded.position[0])
    if abs(first - start) <= FARTHEST_OFF or off_any_rig(recorded):
        return ""  # where no rig has such positions, that is said already
    longer = "the rig may have a longer cylinder.stroke"
    return (
        f"the simulated carriage starts at {1e3 * start:g} mm, the end of its stroke, the recorded "
        f"one at {1e3 * first:g} mm: "
        f"{longer if first > start else 'positions count from the end of chamber A'}"
    )


def _pressures_remark(recorded: MeasuredRun, simulated: MeasuredRun) -> str:
    """Say where the recorded chambers start otherwise than those of the simulated rig."""
    (a, b), (own_a, own_b) = (
        (float(run.pressure_a[0]), float(run.pressure_b[0])) for run in (recorded, simulated)
    )
    if max(abs(a - own_a), abs(b - own_b)) <= FARTHEST_APART or off_any_rig(recorded):
        return ""
    return (
        f"the simulated rig starts at rest with {1e-3 * own_a:.0f} kPa in A and "
        f"{1e-3 * own_b:.0f} kPa in B, the recorded one with {1e-3 * a:.0f} and {1e-3 * b:.0f} "
        "kPa: what they differ by has that in it; record from before the first move on, or use "
        "`rodless replay`, which starts with the recorded pressures"
    )


@dataclass(frozen=True)
class _Steps:
    """Set-points, each in force until the next; until the first the carriage stays where it is."""

    setpoint: Setpoint
    start: float  # m

    def sample(self, time: float) -> tuple[float, float]:
        """Return the set-point in force at ``time`` (s), and no velocity."""
        place = int(np.searchsorted(self.setpoint.time, time, side="right")) - 1
        return (float(self.setpoint.position[place]) if place >= 0 else self.start), 0.0
