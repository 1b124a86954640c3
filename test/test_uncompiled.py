# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The tests of the compiled functions once more, on the same functions as plain Python.

A fault that only compiled or only plain code has would show here, and coverage sees the lines of a
function only where they run as Python.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from every_option import RIGS, run_of

HERE = Path(__file__).resolve().parent

# Tests that call the functions themselves: those that simulate for seconds would take minutes.
QUICK = (
    "rodless_sim/physics/test_breakaway_limit.py",
    "rodless_sim/physics/test_course.py",
    "rodless_sim/physics/test_cylinder.py",
    "rodless_sim/physics/test_derivatives.py",
    "rodless_sim/physics/test_equations.py",
    "rodless_sim/physics/test_events.py",
    "rodless_sim/physics/test_fault_codes.py",
    "rodless_sim/physics/test_flow.py",
    "rodless_sim/physics/test_friction.py",
    "rodless_sim/physics/test_integrator.py",
    "rodless_sim/physics/test_ports.py",
    "rodless_sim/physics/test_settled.py",
    "rodless_sim/physics/test_step_control.py",
    "rodless_sim/physics/test_valve.py",
    "rodless_sim/instruments/test_instruments.py",
    "rodless_sim/instruments/test_sampling.py",
    "rodless_sim/test_rig.py",
    "rodless_control/laws",
    "rodless_control/test_reference_shapes.py",
)
# Among them, but seconds of a rig as well.
LEFT_OUT = "rodless_control/laws/test_laws_on_the_rig.py"
SECONDS_OF_A_RIG = (
    "test_a_change_in_mid_move_does_not_keep_the_carriage_off_its_target",
    "test_a_command_or_a_change_of_nothing_leaves_no_trace",
    "test_a_lag_hardly_depends_on_how_often_it_is_read",
    "test_time_is_counted_without_drift",
    "test_what_has_wound_up_does_not_hold_the_carriage_away_for_good",
)

# To be compiled for the comparison, which takes a minute: of what has most options at once, two.
COMPARED = ("bristles, heat, spool, compressor", "magnets, drift")


def in_python(*arguments: str | Path) -> str:
    """Run Python with compiled functions as plain ones; return what it printed."""
    environment = {
        **os.environ,
        "NUMBA_DISABLE_JIT": "1",
        "PYTHONPATH": os.pathsep.join(path for path in sys.path if path),
    }
    done = subprocess.run(
        [sys.executable, *arguments],
        cwd=HERE.parent,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.slow
def test_they_pass_uncompiled() -> None:
    """With NUMBA_DISABLE_JIT=1 all of them pass, in a process of their own."""
    pytest_here = ("-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "no:cov")
    others = f"not ({' or '.join(SECONDS_OF_A_RIG)})"
    chosen = ("-m", "not ros and not slow", "-k", others, f"--ignore=test/{LEFT_OUT}")
    files = (f"test/{name}" for name in QUICK)
    passed = re.search(r"(\d+) passed", in_python(*pytest_here, *chosen, *files))
    assert passed is not None
    assert int(passed[1]) > 400


@pytest.mark.slow
def test_every_option_moves_as_it_does_compiled(tmp_path: Path) -> None:
    """As plain Python each rig moves, stays on the stroke, and comes out sound.

    Those compared are the compiled ones but for rounding, which grows with each breakaway.
    """
    in_python(HERE / "shared" / "every_option.py", tmp_path / "runs.npz")
    found = np.load(tmp_path / "runs.npz")
    assert set(found.files) == set(RIGS)
    for name in RIGS:
        assert np.isfinite(found[name]).all(), name
        position = found[name][1]
        assert 0.0 <= position.min() < position.max() <= 0.2, name
    for name in COMPARED:
        expected = run_of(name)
        scale = np.abs(expected).max(axis=1, keepdims=True)
        assert np.all(np.abs(found[name] - expected) <= 1e-8 * scale), name
