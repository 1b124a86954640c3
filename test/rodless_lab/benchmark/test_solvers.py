# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The other solvers of the benchmark: they solve the same rig, or say how to get them."""

import sys
from pathlib import Path

import numpy as np
import pytest

from rodless_lab.benchmark.side_by_side import SideBySide, measured
from rodless_lab.benchmark.solvers.casadi_cvodes import CVODES_BY_CASADI
from rodless_lab.benchmark.solvers.ours import COMPILED, IN_C, c_file
from rodless_lab.benchmark.solvers.right_hand_side import HELD, STATES, right_hand_side
from rodless_lab.benchmark.solvers.scipy_solvers import LSODA, RADAU, RK45
from rodless_lab.benchmark.solvers.solver import Solver
from rodless_lab.benchmark.solvers.sundae import CVODE_BY_SUNDAE
from rodless_lab.benchmark.tables import SOLVERS, markdown
from rodless_lab.benchmark.work import Work

# The step begins at 0.5 s; the voltages hold the valve open, then closed.
VOLTAGES = np.repeat([6.0, 5.08], 300)
WORK = Work("paper", "step", VOLTAGES)


def test_the_page_shows_every_solver_with_its_settings() -> None:
    """docs/benchmarks.md has a row of settings for each solver of the bench, as the tables do."""
    page = (Path(__file__).parents[3] / "docs" / "benchmarks.md").read_text(encoding="utf-8")
    for solver in SOLVERS:
        assert f"| {solver.name} | {solver.settings} | " in page


@pytest.mark.parametrize("solver", [RK45, LSODA, RADAU], ids=lambda solver: solver.name)
def test_scipy_solves_the_same_rig(solver: Solver) -> None:
    """From rest into motion and to rest, at a small tolerance: within 10 nm and 10 Pa.

    The converged solution has another method and finds its events another way.
    """
    work = Work("saturating", "step", VOLTAGES)
    run = solver.prepare(work)
    errors = work.errors(run(0.01))
    assert np.ptp(work.converged[:, 0]) > 1e-3
    assert work.converged[-1, 1] == 0.0
    assert errors.position < 1e-8
    assert errors.pressure < 10.0


def test_the_jacobian_is_that_of_the_rates() -> None:
    """Each column agrees with a central difference of the rates, sliding and at rest."""
    rig = right_hand_side(WORK.plant)
    held, found = np.empty(HELD), np.empty((STATES, STATES))
    for state in ([0.05, 0.02, 4e5, 3e5], [0.05, 0.0, 3.6e5, 3.6e5]):
        y = np.array(state)
        rig.hold(y, 6.0, held)
        rig.jacobian(0.0, y, found, held)
        for column, step in enumerate((1e-6, 1e-7, 1.0, 1.0)):
            after, before = np.empty(STATES), np.empty(STATES)
            shift = step * np.eye(STATES)[column]
            rig.rates(0.0, y + shift, after, held)
            rig.rates(0.0, y - shift, before, held)
            slope = (after - before) / (2.0 * step)
            assert found[:, column] == pytest.approx(slope, rel=1e-4, abs=1e-2)


@pytest.mark.parametrize(
    ("solver", "module", "advice"),
    [
        (CVODES_BY_CASADI, "casadi", "not installed: pip install casadi"),
        (CVODE_BY_SUNDAE, "sksundae", "not installed: pip install scikit-sundae"),
    ],
    ids=["casadi", "sundae"],
)
def test_what_is_missing_is_listed_and_the_rest_runs(
    solver: Solver, module: str, advice: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its row says how to get it, without numbers; other rows have theirs."""
    monkeypatch.setitem(sys.modules, module, None)
    work = Work("paper", "step")
    found = SideBySide([work])
    found.measured += measured({COMPILED: (1.0,), solver: (1.0,)}, work, found.missing)
    assert found.missing == {solver.name: advice}
    rows = [line for line in markdown(found).splitlines() if line.startswith(f"| {solver.name}")]
    assert rows[0].endswith(f"| {advice} |")
    assert all(row.endswith("|  |") for row in rows[1:])
    assert found.ratio(found.measured[0]) == 1.0
    assert any(COMPILED.name in name for name in found.figures())
    assert not any(solver.name in name for name in found.figures())


def test_a_missing_c_compiler_is_listed(monkeypatch: pytest.MonkeyPatch) -> None:
    """The row of the C file says that there is no compiler, and which was looked for."""
    c_file.cache_clear()
    monkeypatch.setenv("CC", "no-such-compiler")
    missing: dict[str, str] = {}
    assert list(measured({IN_C: (1.0,)}, WORK, missing)) == []
    assert "no-such-compiler" in missing[IN_C.name]
