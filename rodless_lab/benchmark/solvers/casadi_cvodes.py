# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""CVODES of SUNDIALS by CasADi, which evaluates its own symbols without asking Python."""

import importlib.util
from typing import Any

import numpy as np
import numpy.typing as npt

from rodless_lab.benchmark.solvers.by_periods import Integrate, by_periods
from rodless_lab.benchmark.solvers.right_hand_side import HELD, STATES, right_hand_side
from rodless_lab.benchmark.solvers.solver import UNITS, MissingError, Solver, relative
from rodless_lab.benchmark.work import Work

Array = npt.NDArray[np.float64]

MOST_STEPS = 100_000

# How near to an event is near enough: N, or m/s.
SMALLEST = 1e-9
MOST_TRIALS = 60


class Period:
    """One period of CVODES, of any length.

    CasADi has one absolute tolerance for all states, which therefore are in ``UNITS``.
    """

    def __init__(self, work: Work, tolerance: float) -> None:
        """Build the integrator."""
        import casadi  # noqa: PLC0415  an extra

        from rodless_lab.benchmark.solvers.casadi_model import rates  # noqa: PLC0415

        ca: Any = casadi  # its types are of no use here
        x, p = ca.SX.sym("x", STATES), ca.SX.sym("p", HELD + 1)
        units = ca.DM(UNITS)
        change = p[HELD] * rates(work.plant, x * units, p[:HELD]) / units
        # Called through memory of ours: CasADi's arrays would take longer than the integration. It
        # keeps neither the memory nor the integrator alive.
        self._integrator: Any = ca.integrator(
            "period",
            "cvodes",
            {"x": x, "p": p, "ode": change},
            0.0,
            1.0,
            {
                "abstol": tolerance,
                "reltol": relative(tolerance),
                "max_num_steps": MOST_STEPS,
            },
        )
        self._start, self._constants = np.empty(STATES), np.empty(HELD + 1)
        self._end: Array = np.empty(STATES)
        self._buffer, self._evaluate = self._integrator.buffer()
        self._buffer.set_arg(0, self._start.data)
        self._buffer.set_arg(2, self._constants.data)
        self._buffer.set_res(0, self._end.data)

    def begin(self, state: Array, held: Array) -> None:
        """Take the state at the start, and what is held."""
        np.divide(state, UNITS, out=self._start)
        self._constants[:HELD] = held

    def after(self, duration: float) -> Array:
        """Return the state ``duration`` s after the start."""
        self._constants[HELD] = duration
        self._evaluate()
        return np.asarray(self._end * UNITS, dtype=np.float64)


def cvodes(work: Work, tolerance: float) -> Integrate:
    """Return CVODES at ``tolerance``; raises MissingError without CasADi.

    CasADi's own events cost more than they save here: where one has passed, the period is repeated
    with other lengths until its end is the event, by the method of the false position.
    """
    if importlib.util.find_spec("casadi") is None:
        raise MissingError("not installed: pip install casadi")
    rig, period = right_hand_side(work.plant), Period(work, tolerance)

    def integrate(state: Array, duration: float, held: Array) -> tuple[Array, float]:
        period.begin(state, held)
        found = period.after(duration)
        last = rig.event(0.0, found, held)
        if last >= 0.0:
            return found, duration
        before, value, time = 0.0, rig.event(0.0, state, held), duration
        for _ in range(MOST_TRIALS):
            trial = max(time - last * (time - before) / (last - value), 1e-12 * duration)
            found = period.after(trial)
            new = rig.event(0.0, found, held)
            if (new > 0.0) == (last > 0.0):
                value *= 0.5
            else:
                before, value = time, last
            time, last = trial, new
            if abs(new) < SMALLEST:
                break
        return found, time

    return integrate


CVODES_BY_CASADI = Solver(
    "CasADi, CVODES",
    "BDF, symbolic Jacobian, buffers, events by false position",
    by_periods(cvodes),
)
