"""A recorded run once more, by a simulated rig."""

from dataclasses import replace

import numpy as np

from rodless_lab.runs.measured_run import MeasuredRun, run_of_trace
from rodless_sim import RigParameters, simulate


def rig_of(parameters: RigParameters, recorded: MeasuredRun) -> tuple[RigParameters, float]:
    """Return ``parameters`` at the recorded mean supply, and where the carriage starts (m).

    Raises ParameterError for a supply pressure that no rig has.
    """
    rig = parameters.with_values({"supply.pressure": float(recorded.supply_pressure.mean())})
    stroke = rig.number("cylinder.stroke")
    return rig, float(np.clip(recorded.position[0], 0.0, stroke))


def resimulate(
    parameters: RigParameters,
    recorded: MeasuredRun,
    pressures: tuple[float, float] | None = None,
) -> MeasuredRun:
    """Feed the recorded voltages to a rig at rest where the recorded one starts.

    ``pressures`` (Pa) are what the chambers start with, as :func:`rodless_sim.simulate` takes them.
    Raises as :func:`rig_of`.
    """
    rig, start = rig_of(parameters, recorded)
    trace = simulate(rig, recorded.voltage[:-1], recorded.period, start, pressures)
    run = run_of_trace(trace, rig.number("supply.pressure"))
    # The last voltage acts on nothing in the run, and is the recorded one all the same.
    return replace(run, voltage=recorded.voltage)
