"""A run of the rig as arrays, computed in one compiled loop."""

import numpy as np
import numpy.typing as npt

from rodless_base.columns import Columns, quantities
from rodless_base.kernels import kernel, outlined_kernel
from rodless_sim.physics.equations import Inflows, inflows
from rodless_sim.physics.motion import advance_from
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings
from rodless_sim.physics.state import Motion, State
from rodless_sim.timing import sample_times

Array = npt.NDArray[np.float64]


def read_only(array: Array) -> Array:
    """Return a view of ``array`` that cannot be written; whoever gave it goes on as before."""
    view: Array = np.asarray(array).view()
    view.flags.writeable = False
    return view


class Trace(Columns):
    """A run as arrays, one for each field of :class:`~rodless_sim.State`, one entry per sample.

    Sample 0 is the start. ``voltage[k]`` applies from sample k to sample k+1, and flows are those
    just after it is applied; the last entry has no sample after it. The arrays are read-only:
    change a ``copy()`` of one.

    Parameters
    ----------
    **columns
        The arrays by name, shape (n,) each, SI.

    Raises
    ------
    TypeError
        For a column that is missing or unknown.

    Examples
    --------
    >>> from rodless_sim import RigParameters, simulate
    >>> run = simulate(RigParameters(), [6.0] * 500, period=1e-3)
    >>> f"{run.position[-1] * 1e3:.1f} mm after {run.time[-1]} s"
    '9.1 mm after 0.5 s'
    >>> run.units()["mass_flow_a"]
    'kg/s'

    """

    # The state's fields, for type checkers.
    time: Array
    position: Array
    velocity: Array
    pressure_a: Array
    pressure_b: Array
    voltage: Array
    force: Array
    mass_flow_a: Array
    mass_flow_b: Array

    def __init__(self, **columns: "Array") -> None:
        """Take the columns; raises TypeError."""
        names = list(self.units())
        if columns.keys() != set(names):
            missing, unknown = set(names) - columns.keys(), columns.keys() - set(names)
            raise TypeError(f"columns missing: {sorted(missing)}, unknown: {sorted(unknown)}")
        vars(self).update((name, read_only(columns[name])) for name in names)

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"{name}: a trace cannot be changed")

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"{name}: a trace cannot be changed")

    def __repr__(self) -> str:
        end = f", {self.time[-1]:g} s" if len(self.time) else ""
        return f"{type(self).__name__}: {len(self.time)} samples{end}"

    def units(self) -> dict[str, str]:
        """Return the unit of each column by name: those of the state, then a subclass's own."""
        return {name: unit for name, unit, _ in quantities(State)} | super().units()


# The plant's part of a recorded sample.
COLUMNS = (*Motion._fields, "mass_flow_a", "mass_flow_b")
STATES = len(Motion._fields)


@kernel
def record(state: Motion, flows: Inflows, row: Array) -> None:
    """Write one sample into ``row``: ``COLUMNS``."""
    for k in range(STATES):
        row[k] = state[k]
    row[STATES], row[STATES + 1] = flows.a.mass_flow, flows.b.mass_flow


@outlined_kernel
def run_open_loop(
    plant: Plant, voltages: Array, state: Motion, period: float, tolerance: float
) -> tuple[Array, Motion, int, int]:
    """Apply each of ``voltages`` (shape (n,), V, n > 0) for ``period`` s.

    Returns rows 0 to n, the last state, how many voltages were applied, and the fault at which that
    ended, as :func:`advance` returns it.
    """
    rows = np.empty((voltages.size + 1, len(COLUMNS)))
    for k in range(voltages.size):
        lands = openings(plant, voltages[k])
        flows = inflows(plant, lands, state)
        record(state, flows, rows[k])
        state, fault = advance_from(plant, lands, state, flows, period, tolerance)
        if fault != 0:
            return rows, state, k, fault
    record(state, inflows(plant, openings(plant, voltages[-1]), state), rows[-1])
    return rows, state, voltages.size, 0


def trace(plant: Plant, period: int, voltage: Array, rows: Array) -> Trace:
    """Name the columns of ``rows``, sampled every ``period`` ns: shape (n, len(``COLUMNS``))."""
    columns = dict(zip(COLUMNS, rows.T.copy(), strict=True))
    area = plant.cylinder.piston_area
    return Trace(
        time=sample_times(len(rows), period),
        voltage=voltage,
        force=area * (columns["pressure_a"] - columns["pressure_b"]),
        **columns,
    )
