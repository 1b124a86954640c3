"""A run of the rig as arrays, computed in one compiled loop."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import numpy.typing as npt

from rodless_base.columns import Columns
from rodless_base.kernels import kernel
from rodless_sim.physics.motion import Motion, Plant, advance, chamber_flows
from rodless_sim.timing import sample_times

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Trace(Columns):
    """Arrays named like :class:`~rodless_sim.rig.State`, one entry per sample, SI.

    Sample 0 is the start. ``voltage[k]`` is held from sample k to sample k+1, and flows are
    those just after it is applied; the last entry has no sample after it.
    """

    time: Annotated[Array, "s"]
    position: Annotated[Array, "m"]
    velocity: Annotated[Array, "m/s"]
    pressure_a: Annotated[Array, "Pa"]
    pressure_b: Annotated[Array, "Pa"]
    voltage: Annotated[Array, "V"]
    force: Annotated[Array, "N"]
    mass_flow_a: Annotated[Array, "kg/s"]
    mass_flow_b: Annotated[Array, "kg/s"]


# The plant's part of a recorded sample, in the order of the columns.
COLUMNS = ("position", "velocity", "pressure_a", "pressure_b", "mass_flow_a", "mass_flow_b")


@kernel
def record(plant: Plant, voltage: float, state: Motion, row: Array) -> None:
    """Write one sample into ``row``, shape (6,): see ``COLUMNS``."""
    row[0] = state.position
    row[1] = state.velocity
    row[2] = state.pressure_a
    row[3] = state.pressure_b
    row[4], row[5] = chamber_flows(plant, voltage, state)


@kernel
def run_open_loop(
    plant: Plant, voltages: Array, state: Motion, steps: int, step: float
) -> tuple[Array, Motion]:
    """Hold each of ``voltages`` (shape (n,), V) for ``steps`` inner steps; rows 0 to n."""
    rows = np.empty((voltages.size + 1, 6))
    for k in range(voltages.size):
        record(plant, voltages[k], state, rows[k])
        state = advance(plant, voltages[k], state, steps, step)
    record(plant, voltages[-1], state, rows[-1])
    return rows, state


def trace(plant: Plant, period: int, voltage: Array, rows: Array) -> Trace:
    """Name the columns of ``rows``, shape (n, 6), sampled every ``period`` ns."""
    columns = dict(zip(COLUMNS, rows.T.copy(), strict=True))
    area = plant.cylinder.piston_area
    return Trace(
        time=sample_times(len(rows), period),
        voltage=voltage,
        force=area * (columns["pressure_a"] - columns["pressure_b"]),
        **columns,
    )
