# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A run of the rig as arrays, computed in one compiled loop."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from rodless_base.columns import Columns, quantities
from rodless_base.kernels import kernel, kernel_by_type, outlined_kernel, version_for
from rodless_sim.physics import full
from rodless_sim.physics.course import course_at, spool_of
from rodless_sim.physics.dead_time import advance_period, arriving
from rodless_sim.physics.equations import Inflows, inflows
from rodless_sim.physics.lands import AnyCourse, Course, Timed
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.spool import AnySpool, spool_voltage
from rodless_sim.physics.state import (
    FURTHER,
    SPOOL,
    TEMPERATURES,
    AnyMotion,
    FullMotion,
    HeatedMotion,
    Motion,
    State,
    state_with,
)
from rodless_sim.timing import sample_times

Array = npt.NDArray[np.float64]


def read_only(array: Array) -> Array:
    """Return a view of ``array`` that cannot be written; whoever gave it goes on as before."""
    view: Array = np.asarray(array).view()
    view.flags.writeable = False
    return view


class Trace(Columns):
    """A run as arrays, one for each field of :class:`~rodless_sim.State`, one entry per sample.

    Of a rig with further states, such as temperatures of its own, it has those of its state.

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
    # Those of further options.
    bristle_deflection: Array
    piston_position: Array
    piston_velocity: Array
    piston_bristle_deflection: Array
    coupled: Array
    supply_pressure: Array
    receiver_pressure: Array
    compressor: Array
    static_drift: Array
    coulomb_drift: Array
    viscous_drift: Array
    # That of a rig whose spool does not follow at once.
    spool_voltage: Array

    def __init__(self, **columns: "Array") -> None:
        """Take the columns; raises TypeError."""
        # Before they are asked for by name: which there are follows from those given.
        vars(self).update((name, None) for name in FURTHER if name in columns)
        names = list(self.units())
        if columns.keys() != set(names):
            missing, unknown = set(names) - columns.keys(), columns.keys() - set(names)
            raise TypeError(f"columns missing: {sorted(missing)}, unknown: {sorted(unknown)}")
        vars(self).update((name, read_only(columns[name])) for name in names)

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Take back what :mod:`pickle` and :mod:`copy` had: arrays that were read-only."""
        vars(self).update(
            (name, read_only(value) if isinstance(value, np.ndarray) else value)
            for name, value in state.items()
        )

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"{name}: a trace cannot be changed")

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"{name}: a trace cannot be changed")

    def __repr__(self) -> str:
        end = f", {self.time[-1]:g} s" if len(self.time) else ""
        return f"{type(self).__name__}: {len(self.time)} samples{end}"

    def units(self) -> dict[str, str]:
        """Return the unit of each column by name: those of the state, then a subclass's own."""
        kind = state_with(tuple(name for name in FURTHER if name in vars(self)))
        return {name: unit for name, unit, _ in quantities(kind)} | super().units()


# The plant's part of a recorded sample.
EVERYWHERE = len(Motion._fields)  # states that every rig has
FLOWS = ("mass_flow_a", "mass_flow_b")
COLUMNS = (*Motion._fields, *FLOWS)
HEATED_COLUMNS = (*HeatedMotion._fields, *FLOWS)
MOST_COLUMNS = len(FullMotion._fields) + len(FLOWS) + len(SPOOL)


def further_states_of(plant: Plant) -> tuple[str, ...]:
    """Return the names of the states that are shown of the plant, but for those of every rig."""
    if plant.full:
        return full.further_of(plant.full)
    return TEMPERATURES if plant.heat else ()


def columns_of(plant: Plant) -> tuple[str, ...]:
    """Return the names of what is recorded of each sample."""
    spool = SPOOL if plant.drive else ()
    return (*Motion._fields, *further_states_of(plant), *FLOWS, *spool)


def further_of(plant: Plant) -> tuple[str, ...]:
    """Return the names of what a state of the plant has behind what every rig has."""
    return further_states_of(plant) + (SPOOL if plant.drive else ())


def shown(plant: Plant, motion: AnyMotion) -> tuple[float, ...]:
    """Return the values of the states that are shown: those of every rig, then the further ones."""
    further = further_states_of(plant)
    return (*motion[:EVERYWHERE], *(getattr(motion, name) for name in further))


@kernel
def record(plant: Plant, state: AnyMotion, course: AnyCourse, flows: Inflows, row: Array) -> None:
    """Write one sample into ``row``: ``columns_of`` the plant."""
    states = record_states(plant, state, row)
    row[states], row[states + 1] = flows.a.mass_flow, flows.b.mass_flow
    record_spool(course, row)


@kernel_by_type
def record_states(plant: Plant, state: AnyMotion, row: Array) -> int:  # noqa: ARG001
    """Write the states that are shown, and return their number."""
    states = len(state)
    for k in range(states):
        row[k] = state[k]
    return states


@version_for(FullMotion, record_states)
def _record_states(plant: Plant, state: FullMotion, row: Array) -> int:
    for k in range(EVERYWHERE):
        row[k] = state[k]
    count: int = plant.full.shown_count
    for k in range(count):
        row[EVERYWHERE + k] = state[plant.full.shown[k]]
    return EVERYWHERE + count


@kernel_by_type
def record_spool(course: AnyCourse, row: Array) -> None:
    """Write where the spool is behind all else; nothing where it follows at once."""


@version_for(Course, record_spool)
def _record_spool(course: Course, row: Array) -> None:
    row[row.size - 1] = spool_voltage(course.spool)


@version_for(Timed, record_spool)
def _record_timed_spool(course: Timed, row: Array) -> None:
    record_spool(course.valve, row)


@outlined_kernel
def run_open_loop(
    plant: Plant,
    voltages: Array,
    state: AnyMotion,
    spool: AnySpool,
    period: int,
    tolerance: float,
    columns: int,
) -> tuple[Array, AnyMotion, AnySpool, int, int]:
    """Apply each of ``voltages`` (shape (n,), V, n > 0) for ``period`` ns.

    Returns rows 0 to n of so many ``columns``, the last state and spool, how many voltages were
    applied, and the fault at which that ended, as :func:`advance` returns it.
    """
    rows = np.empty((voltages.size + 1, columns))
    closed = plant.valve.closed_voltage
    for k in range(voltages.size):
        arrivals = arriving(plant.drive, voltages, k, period, closed)
        course = course_at(plant, spool, arrivals[0])
        flows = inflows(plant, course, state)
        record(plant, state, course, flows, rows[k])
        state, course, fault = advance_period(
            plant, course, state, flows, arrivals, period, tolerance
        )
        spool = spool_of(course)
        if fault != 0:
            return rows, state, spool, k, fault
    # The last voltage is held: what arrives as the run ends has arrived.
    held = np.append(voltages, voltages[-1])
    course = course_at(plant, spool, arriving(plant.drive, held, voltages.size, period, closed)[0])
    record(plant, state, course, inflows(plant, course, state), rows[-1])
    return rows, state, spool, voltages.size, 0


def trace(
    names: Sequence[str], area: float | Array, period: int, voltage: Array, rows: Array
) -> Trace:
    """Name the columns of ``rows``, sampled every ``period`` ns: shape (n, k).

    The piston's ``area`` (m²) is one, or one for each row.
    """
    columns = dict(zip(names, rows.T.copy(), strict=True))
    return Trace(
        time=sample_times(len(rows), period),
        voltage=voltage,
        force=area * (columns["pressure_a"] - columns["pressure_b"]),
        **columns,
    )


def columns_of_states(states: Sequence[State], period: int) -> dict[str, Array]:
    """Return the fields of states that are ``period`` ns apart, the first at 0, as arrays.

    NaN where a state has not what another one has: a rig may change its equations in mid-run.
    """
    kinds = {type(state): state._fields for state in states}
    names = dict.fromkeys(name for fields in kinds.values() for name in fields)
    columns = {
        name: np.array([getattr(one, name) if name in one._fields else np.nan for one in states])
        for name in names
    }
    return {**columns, "time": sample_times(len(states), period)}
