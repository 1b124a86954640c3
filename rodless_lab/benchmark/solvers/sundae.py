# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""CVODE of SUNDIALS by scikit-sundae, which calls Python functions only, compiled or not."""

import importlib.util
from typing import Any

import numpy as np
import numpy.typing as npt

from rodless_lab.benchmark.solvers.by_periods import Integrate, by_periods
from rodless_lab.benchmark.solvers.right_hand_side import HELD, right_hand_side
from rodless_lab.benchmark.solvers.solver import UNITS, MissingError, Solver, relative
from rodless_lab.benchmark.work import Work

Array = npt.NDArray[np.float64]

MOST_STEPS = 100_000


def cvode(work: Work, tolerance: float) -> Integrate:
    """Return CVODE's BDF at ``tolerance``; raises MissingError without scikit-sundae."""
    if importlib.util.find_spec("sksundae") is None:
        raise MissingError("not installed: pip install scikit-sundae")
    from sksundae.cvode import CVODE  # noqa: PLC0415  an extra

    rig = right_hand_side(work.plant)
    held = np.zeros(HELD)

    def event(time: float, y: Array, found: Array, user: tuple[Array]) -> None:
        found[0] = rig.event(time, y, user[0])

    event.terminal, event.direction = [True], [-1]  # type: ignore[attr-defined]
    solver: Any = CVODE(
        lambda time, y, change, user: rig.rates(time, y, change, user[0]),
        jacfn=lambda time, y, _change, found, user: rig.jacobian(time, y, found, user[0]),
        eventsfn=event,
        num_events=1,
        userdata=(held,),
        rtol=relative(tolerance),
        atol=tolerance * UNITS,
        max_num_steps=MOST_STEPS,
    )

    def integrate(state: Array, duration: float, now_held: Array) -> tuple[Array, float]:
        held[:] = now_held
        solver.init_step(0.0, state)
        found = solver.step(duration, tstop=duration)
        if not found.success:
            raise RuntimeError(f"CVODE: {found.message}")
        return np.array(found.y), float(found.t)

    return integrate


CVODE_BY_SUNDAE = Solver(
    "scikit-sundae, CVODE",
    "BDF, dense, compiled functions and Jacobian, events",
    by_periods(cvode),
)
