# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""scipy's ``solve_ivp`` with compiled functions, its events and, where it takes one, a Jacobian."""

from typing import Any, Literal

import numpy as np
import numpy.typing as npt
from scipy.integrate import solve_ivp

from rodless_lab.benchmark.solvers.by_periods import Integrate, Method, by_periods
from rodless_lab.benchmark.solvers.right_hand_side import STATES, right_hand_side
from rodless_lab.benchmark.solvers.solver import UNITS, Solver, relative
from rodless_lab.benchmark.work import Work

Array = npt.NDArray[np.float64]
Name = Literal["RK45", "LSODA", "Radau"]


def method(name: Name, implicit: bool, whole_period: bool) -> Method:
    """Return ``solve_ivp``'s method ``name``.

    ``implicit`` methods are given the Jacobian. With ``whole_period`` the first step tried is the
    period, which saves a search; LSODA would take it without looking.
    """

    def at(work: Work, tolerance: float) -> Integrate:
        rig = right_hand_side(work.plant)
        held = np.empty(0)

        def rates(time: float, y: Array) -> Array:
            change = np.empty(STATES)
            rig.rates(time, y, change, held)
            return change

        def jacobian(time: float, y: Array) -> Array:
            found = np.empty((STATES, STATES))
            rig.jacobian(time, y, found, held)
            return found

        def event(time: float, y: Array) -> float:
            return rig.event(time, y, held)

        event.terminal, event.direction = True, -1.0  # type: ignore[attr-defined]
        options: dict[str, Any] = {"jac": jacobian} if implicit else {}

        def integrate(state: Array, duration: float, now_held: Array) -> tuple[Array, float]:
            nonlocal held
            held = now_held
            found = solve_ivp(
                rates,
                (0.0, duration),
                state,
                method=name,
                rtol=relative(tolerance),
                atol=tolerance * UNITS,
                events=event,
                first_step=duration if whole_period else None,
                **options,
            )
            if not found.success:
                raise RuntimeError(f"{name}: {found.message}")
            return found.y[:, -1].copy(), float(found.t[-1])

        return integrate

    return at


RK45 = Solver(
    "scipy `solve_ivp`, RK45",
    "compiled functions, events, first step 1 ms",
    by_periods(method("RK45", implicit=False, whole_period=True)),
)
LSODA = Solver(
    "scipy `solve_ivp`, LSODA",
    "compiled functions and Jacobian, events",
    by_periods(method("LSODA", implicit=True, whole_period=False)),
)
RADAU = Solver(
    "scipy `solve_ivp`, Radau",
    "compiled functions and Jacobian, events, first step 1 ms",
    by_periods(method("Radau", implicit=True, whole_period=True)),
)
