# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A run of the rig as arrays, computed in one compiled loop."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from rodless_base.columns import Columns, quantities
from rodless_base.kernels import kernel, outlined_kernel
from rodless_sim.physics.equations import Inflows, inflows
from rodless_sim.physics.motion import advance_from
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings
from rodless_sim.physics.state import AnyMotion, HeatedMotion, HeatedState, Motion, State
from rodless_sim.timing import sample_times

Array = npt.NDArray[np.float64]


def read_only(array: Array) -> Array:
    """Return a view of ``array`` that cannot be written; whoever gave it goes on as before."""
    view: Array = np.asarray(array).view()
    view.flags.writeable = False
    return view


class Trace(Columns):
    """A run as arrays, one for each field of :class:`~rodless_sim.State`, one entry per sample.

    Of a rig with temperatures of its own it has those of :class:`~rodless_sim.HeatedState`.

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
    # Those of a rig whose chambers have temperatures.
    temperature_a: Array
    temperature_b: Array

    def __init__(self, **columns: "Array") -> None:
        """Take the columns; raises TypeError."""
        # Before they are asked for by name: which there are follows from those given.
        vars(self).update((name, None) for name in FURTHER if name in columns)
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
        kind = HeatedState if any(name in vars(self) for name in FURTHER) else State
        return {name: unit for name, unit, _ in quantities(kind)} | super().units()


# What a trace has only of a rig with these states.
FURTHER = tuple(name for name in HeatedMotion._fields if name not in Motion._fields)

# The plant's part of a recorded sample.
FLOWS = ("mass_flow_a", "mass_flow_b")
COLUMNS = (*Motion._fields, *FLOWS)
HEATED_COLUMNS = (*HeatedMotion._fields, *FLOWS)


def columns_of(plant: Plant) -> tuple[str, ...]:
    """Return the names of what is recorded of each sample."""
    return HEATED_COLUMNS if plant.heat else COLUMNS


@kernel
def record(state: AnyMotion, flows: Inflows, row: Array) -> None:
    """Write one sample into ``row``: ``columns_of`` the plant."""
    states = len(state)
    for k in range(states):
        row[k] = state[k]
    row[states], row[states + 1] = flows.a.mass_flow, flows.b.mass_flow


@outlined_kernel
def run_open_loop(
    plant: Plant, voltages: Array, state: AnyMotion, period: float, tolerance: float
) -> tuple[Array, AnyMotion, int, int]:
    """Apply each of ``voltages`` (shape (n,), V, n > 0) for ``period`` s.

    Returns rows 0 to n, the last state, how many voltages were applied, and the fault at which that
    ended, as :func:`advance` returns it.
    """
    rows = np.empty((voltages.size + 1, len(state) + len(FLOWS)))
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
    """Name the columns of ``rows``, sampled every ``period`` ns: shape (n, k) as :func:`record`."""
    columns = dict(zip(columns_of(plant), rows.T.copy(), strict=True))
    area = plant.cylinder.piston_area
    return Trace(
        time=sample_times(len(rows), period),
        voltage=voltage,
        force=area * (columns["pressure_a"] - columns["pressure_b"]),
        **columns,
    )


def columns_of_states(states: Sequence[State], period: int) -> dict[str, Array]:
    """Return the fields of states that are ``period`` ns apart, the first at 0, as arrays."""
    columns = {
        name: np.array([getattr(state, name) for state in states]) for name in states[0]._fields
    }
    return {**columns, "time": sample_times(len(states), period)}
