"""Rig and PID in one compiled loop, without ROS."""

from typing import Annotated

import numpy as np
import numpy.typing as npt

from rodless_base.constants import SECONDS_PER_NANOSECOND
from rodless_base.kernels import kernel
from rodless_base.measurement import Measurement
from rodless_control import PidParameters
from rodless_control.laws.pid import Gains, at_rest, gains_of, update
from rodless_control.references import Reference
from rodless_sim import Rig, RigParameters, Trace
from rodless_sim.instruments.instruments import Instruments, Lags, read_rig
from rodless_sim.instruments.sampling import NOISE_CHANNELS, instruments_and_noise
from rodless_sim.physics.motion import advance
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings
from rodless_sim.physics.state import Motion
from rodless_sim.timing import division, nanoseconds
from rodless_sim.trace import COLUMNS, record, trace

Array = npt.NDArray[np.float64]


class ClosedLoopTrace(Trace):
    """A run of the rig with the reference it followed and the error r − y.

    Position, pressures and force are as the instruments of ``sensors.*`` read them, the rest is
    true. :func:`rodless_sim.simulate` of ``voltage`` gives the true ones.
    """

    reference: Annotated[Array, "m", "reference for the position"]
    error: Annotated[Array, "m", "reference less the position read"]


@kernel
def truth(plant: Plant, stamp: int, state: Motion) -> Measurement:
    """Return what instruments without errors would read at ``stamp`` (ns)."""
    return Measurement(
        stamp, state.position, state.pressure_a, state.pressure_b, plant.supply_pressure
    )


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
    span: int,
) -> tuple[Array, Array]:
    """Control ``state`` along ``references`` (shape (n, 2): m, m/s), one row per sample.

    Samples are ``span`` ns apart. ``noise``, shape (n, 4), are what the instruments' noise is made
    of. Returns the rows of :func:`rodless_sim.trace.record` as read, and the commands, (n,).
    """
    rows = np.empty((len(references), len(COLUMNS)))
    voltages = np.empty(len(references))
    true = truth(plant, 0, state)
    lags = Lags(true, true)
    read, _ = read_rig(instruments, lags, true, noise[0])
    memory = at_rest(read.position)
    for k in range(len(references)):
        since = 0.0 if k == 0 else span * SECONDS_PER_NANOSECOND
        read, lags = read_rig(instruments, lags, truth(plant, k * span, state), noise[k])
        memory, command = update(
            gains, memory, references[k, 0], references[k, 1], read.position, since
        )
        voltages[k] = command.voltage
        lands = openings(plant, command.voltage)
        record(plant, lands, state, rows[k])
        rows[k, 0], rows[k, 2], rows[k, 3] = read.position, read.pressure_a, read.pressure_b
        state = advance(plant, lands, state, steps, step)
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
    references = np.array(
        [reference.sample(k * span * SECONDS_PER_NANOSECOND) for k in range(count)]
    )
    instruments, noise = instruments_and_noise(rig_parameters)
    rows, voltages = run_closed_loop(
        rig.plant,
        instruments,
        noise.standard_normal((count, NOISE_CHANNELS)),
        gains_of(pid_parameters),
        references,
        rig.motion,
        steps,
        step,
        span,
    )
    run = trace(rig.plant, span, voltages, rows)
    wanted = references[:, 0]
    return ClosedLoopTrace(**run.columns(), reference=wanted, error=wanted - run.position)
