"""Rig and PID in one compiled loop, without ROS."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import numpy.typing as npt

from rodless_base.kernels import kernel
from rodless_control import PidParameters
from rodless_control.laws.pid import Gains, at_rest, gains_of, update
from rodless_control.references import Reference
from rodless_sim import Rig, RigParameters, Trace
from rodless_sim.instruments.instruments import Instruments, Lags, Readings, read_rig
from rodless_sim.instruments.sampling import NOISE_CHANNELS, drawn
from rodless_sim.physics.motion import Motion, Plant, advance
from rodless_sim.timing import division, nanoseconds
from rodless_sim.trace import record, trace

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class ClosedLoopTrace(Trace):
    """A run of the rig with the reference it followed (m) and the error r − y (m).

    Position, pressures and force are as the instruments of ``sensors.*`` read them, the rest is
    true. :func:`rodless_sim.simulate` of ``voltage`` gives the true ones.
    """

    reference: Annotated[Array, "m"]
    error: Annotated[Array, "m"]


@kernel
def readable(plant: Plant, state: Motion) -> Readings:
    """Return the true values of what the instruments read."""
    return Readings(state.position, state.pressure_a, state.pressure_b, plant.supply_pressure)


@kernel
def run_closed_loop(
    plant: Plant,
    instruments: Instruments,
    noise: Array,
    gains: Gains,
    references: Array,
    state: Motion,
    steps: int,
    step: float,
    interval: float,
) -> tuple[Array, Array]:
    """Control ``state`` along ``references`` (shape (n, 2): m, m/s), one row per sample.

    ``noise``, shape (n, 4), are what the instruments' noise is made of. Returns the rows of
    :func:`rodless_sim.trace.record`, shape (n, 6), as read, and the commands, (n,).
    """
    rows = np.empty((len(references), 6))
    voltages = np.empty(len(references))
    true = readable(plant, state)
    lags = Lags(true, true)
    read, _ = read_rig(instruments, lags, true, 0.0, noise[0])
    memory = at_rest(read.position)
    for k in range(len(references)):
        since = 0.0 if k == 0 else interval
        true = readable(plant, state)
        read, lags = read_rig(instruments, lags, true, since, noise[k])
        memory, command = update(
            gains, memory, references[k, 0], references[k, 1], read.position, since
        )
        voltages[k] = command.voltage
        record(plant, command.voltage, state, rows[k])
        rows[k, 0], rows[k, 2], rows[k, 3] = read.position, read.pressure_a, read.pressure_b
        state = advance(plant, command.voltage, state, steps, step)
    return rows, voltages


def closed_loop(
    rig_parameters: RigParameters,
    pid_parameters: PidParameters,
    reference: Reference,
    duration: float,
    period: float,
    position: float | None = None,
) -> ClosedLoopTrace:
    """Control a rig at rest for ``duration`` s with a sample and a command every ``period`` s.

    The carriage starts at ``position`` (m; default ``cylinder.initial_position``). Samples 0 to
    ``duration``/``period`` are returned. Raises ValueError for times that are not positive.
    """
    rig = Rig(rig_parameters)
    rig.reset(position)
    span, steps, step = division(period, rig_parameters.number("time.inner_step"))
    count = round(nanoseconds(duration) / span) + 1
    references = np.array([reference.sample(k * span * 1e-9) for k in range(count)])
    instruments, noise = drawn(rig_parameters)
    rows, voltages = run_closed_loop(
        rig.plant,
        instruments,
        noise.standard_normal((count, NOISE_CHANNELS)),
        gains_of(pid_parameters),
        references,
        rig.motion,
        steps,
        step,
        span * 1e-9,
    )
    run = trace(rig.plant, span, voltages, rows)
    wanted = references[:, 0]
    return ClosedLoopTrace(**vars(run), reference=wanted, error=wanted - run.position)
