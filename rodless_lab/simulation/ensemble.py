# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Many rigs under one law along one reference: the figures of each run, over all cores."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from rodless_base.columns import Columns, quantities
from rodless_base.one_line import described, shown
from rodless_control.controller import LawError
from rodless_control.references import Reference
from rodless_lab.simulation.closed_loop import AnyLaw, Loop
from rodless_lab.simulation.in_order import check_workers, cores, in_order
from rodless_lab.simulation.run_metrics import NO_METRICS, RunMetrics, metrics_of
from rodless_sim import RigParameters, SimulationError
from rodless_sim.scenario import AnyScenario, ScenarioStateError

Array = npt.NDArray[np.float64]


class Ensemble(Columns):
    """The :class:`RunMetrics` of many runs as columns, one entry per rig in the order given.

    ``metrics["settling_time"]`` is an array of shape (n,); :meth:`columns`, :meth:`to_dataframe`
    and :meth:`save` have them all. ``failures`` says, by place, why a run has no figures (they are
    NaN): its motion left what a rig can do, its state did not allow what its scenario changes, or
    its law answered with no command.
    """

    def __init__(self, runs: Iterable[RunMetrics], failures: Mapping[int, str]) -> None:
        """Take the figures of each run."""
        rows = np.array(list(runs), dtype=np.float64).reshape(-1, len(RunMetrics._fields))
        self._columns: dict[str, Array] = dict(zip(RunMetrics._fields, rows.T.copy(), strict=True))
        self.failures = dict(failures)

    def __getitem__(self, name: str) -> Array:
        """Return a figure of all runs, shape (n,); raises KeyError."""
        return self._columns[name]

    def __len__(self) -> int:
        return len(self._columns["final_error"])

    def __repr__(self) -> str:
        return f"Ensemble: {len(self)} runs, {len(self.failures)} failed"

    def columns(self) -> dict[str, npt.NDArray[Any]]:
        """Return the figures by name, shape (n,) each."""
        return dict(self._columns)

    def units(self) -> dict[str, str]:
        """Return the unit of each figure by name."""
        return {quantity.name: quantity.unit for quantity in quantities(RunMetrics)}


def outcome(run: Callable[[], RunMetrics]) -> tuple[RunMetrics, str]:
    """Return the figures of a run, and why it has none: empty where it has."""
    try:
        return run(), ""
    except (SimulationError, ScenarioStateError, LawError) as error:
        return NO_METRICS, described(error)


def at_once(loop: Loop, workers: int | None) -> int:
    """Return how many of ``workers`` (default: one for each core) may run rigs at once.

    One where the law is in plain Python, and no more than there is memory for.
    """
    wanted = (cores() if workers is None else workers) if loop.compiled else 1
    return max(1, min(wanted, loop.room))


def ensemble(
    rigs: Iterable[RigParameters],
    law: AnyLaw,
    reference: Reference,
    duration: float = 6.0,
    period: float = 1e-3,
    position: float | None = None,
    since: float = 0.0,
    workers: int | None = None,
    progress: Callable[[int], None] | None = None,
    scenario: Callable[[RigParameters], AnyScenario | None] | None = None,
) -> Ensemble:
    """Control each of ``rigs`` as :func:`rodless_lab.closed_loop` does, and keep its figures.

    Each run has the bits of ``closed_loop(rig, law, reference, duration, period, position)``: they
    depend neither on the other rigs, nor on their order, nor on ``workers``. The traces are dropped
    at once, so that memory stays flat however many rigs a generator yields.

    Parameters
    ----------
    rigs
        The rigs, each with a ``sensors.seed`` of its own; :func:`rodless_lab.draw` draws some.
    law
        As closed_loop takes it. A compiled law runs on all cores. One in plain Python, which the
        GIL keeps to one core anyway and which may remember things of its own, runs rig by rig.
    reference
        As closed_loop takes it.
    duration, period, position
        In s, s and m, as closed_loop takes them.
    since
        When peak and RMS of the error begin to count, in s.
    workers
        Threads; by default one for each core, and no more than there is memory for.
    progress
        Called with the number of runs done, after each.
    scenario
        Called with each rig: what happens to it on the way, as closed_loop takes it.

    Raises
    ------
    ValueError, TypeError, ParameterError
        As closed_loop, but for runs that fail by themselves: see :class:`Ensemble`.

    Examples
    --------
    >>> from rodless_control import PidParameters, references
    >>> from rodless_lab import draw, ensemble
    >>> rigs = draw({"cylinder.moving_mass": (0.7, 2.0), "supply.pressure": (5e5, 7e5)}, count=4)
    >>> step = references.step(0.0, 0.058, at=0.1)
    >>> found = ensemble(rigs, PidParameters.preset("calibrated"), step, duration=3.0)
    >>> bool((abs(found["mean_error"]) < 5e-4).all()), found.failures
    (True, {})
    """
    if isinstance(rigs, Mapping | str | bytes | np.ndarray) or not isinstance(rigs, Iterable):
        raise TypeError(f"rigs {shown(rigs)} refused: must be a sequence of RigParameters")
    check_workers(workers)
    loop = Loop(law, reference, duration, period)

    def figures(rig: RigParameters) -> RunMetrics:
        run = loop.run(rig, position, scenario(rig) if scenario else None)
        return metrics_of(loop.times, loop.wanted, run.rows, run.flows, run.commands, since)

    def run(rig: RigParameters) -> tuple[RunMetrics, str]:
        return outcome(lambda: figures(rig))

    found = []
    for one in in_order(run, rigs, at_once(loop, workers)):
        found.append(one)
        if progress is not None:
            progress(len(found))
    failures = {place: why for place, (_, why) in enumerate(found) if why}
    return Ensemble((metrics for metrics, _ in found), failures)
