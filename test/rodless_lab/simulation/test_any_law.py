# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""closed_loop takes any law, and gives it what the instruments read."""

import importlib
import math
import re
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from rodless_base.parameters import Parameter, declare
from rodless_control import (
    CompiledLaw,
    ControllerParameters,
    Law,
    Measurement,
    Pid,
    PidParameters,
    ReferencePoint,
    references,
)
from rodless_lab import ClosedLoopTrace, closed_loop
from rodless_lab.simulation.closed_loop import AnyLaw, compiled_loop
from rodless_sim import RigParameters, simulate
from rodless_sim.instruments.instruments import DATA_SHEET

STEP = references.step(0.02, 0.03, at=0.05)
NOISY = RigParameters.preset("paper").with_values(DATA_SHEET)
PID = Pid()
COLUMNS = ("position", "pressure_a", "pressure_b", "voltage", "mass_flow_a", "reference", "error")

# A user's compiled law: proportional, less a share of the difference of the pressures.
COMPILED = """
from typing import NamedTuple

from rodless_base.kernels import kernel
from rodless_base.parameters import Parameter, declare
from rodless_control import CompiledLaw
from rodless_control.controller import Kernels


class Gains(NamedTuple):
    gain: float
    damping: float


class Memory(NamedTuple):
    force: float


class Command(NamedTuple):
    voltage: float
    force: float


def gains_of(parameters):
    return Gains(parameters.number("mine.gain"), parameters.number("mine.damping"))


@kernel
def begin(gains, measurement):
    return Memory(measurement.pressure_a - measurement.pressure_b)


@kernel
def update(gains, memory, measurement, reference, interval):
    force = measurement.pressure_a - measurement.pressure_b
    error = reference.position - measurement.position
    voltage = 5.08 + gains.gain * error - gains.damping * (force - memory.force)
    return Memory(force), Command(voltage, force)


class Damped(CompiledLaw):
    PARAMETERS = declare(
        Parameter("mine.gain", 80.0, "V/m", "gain", "tuned", 0.0, 1e4),
        Parameter("mine.damping", 1e-5, "V/Pa", "damping", "tuned", 0.0, 1.0),
    )
    TERMS = ("force",)
    KERNELS = Kernels(gains_of, begin, update)
"""


class StepwisePid(Pid):
    """A PID that wants to be asked in Python."""

    def update(self, *sample: object) -> object:
        """Ask the PID."""
        return super().update(*sample)


class Spied(Law):
    """Holds a voltage and remembers what it is given."""

    def reset(self) -> None:
        """Forget."""
        self.seen: list[tuple[Measurement, ReferencePoint, float]] = []

    def update(self, *sample: object) -> float:
        """Remember."""
        self.seen.append(sample)
        return 5.3


def run(law: AnyLaw, rig: RigParameters = NOISY, duration: float = 0.4) -> ClosedLoopTrace:
    """A run from 20 mm at 1 kHz."""
    return closed_loop(rig, law, STEP, duration, 1e-3, position=0.02)


def same(first: ClosedLoopTrace, second: ClosedLoopTrace) -> bool:
    """Whether two runs agree to the last bit, and hold motion at all."""
    assert np.ptp(first.position) > 1e-3
    assert first.terms.keys() == second.terms.keys()
    return all(np.array_equal(getattr(first, c), getattr(second, c)) for c in COLUMNS) and all(
        np.array_equal(values, second.terms[name]) for name, values in first.terms.items()
    )


@pytest.mark.parametrize(
    "law",
    [
        Pid(),
        Pid,
        StepwisePid(),
        ControllerParameters(),
        lambda m, r: PID.update(m, r, 1e-3 if m.stamp else 0.0).voltage,
    ],
    ids=["law", "class", "stepwise", "whole set", "function"],
)
def test_a_pid_is_the_same_however_it_is_given(law: AnyLaw) -> None:
    """As parameters, as an object, step by step in Python, as a function: the same bits."""
    model = run(PidParameters())
    found = run(law)
    # A function has no terms.
    assert same(model if found.terms else model.with_terms({}), found)


def test_the_terms_of_a_law_come_with_the_run() -> None:
    """Each of the PID's terms, sample by sample: they add up to the voltage."""
    bare = {"controller.dead_zone_voltage": 0.0, "controller.kp": 300.0, "controller.kd": 0.0}
    found = run(PidParameters(bare), RigParameters())
    terms = found.terms
    assert list(terms) == ["error", "p", "i", "d", "feedforward"]
    assert np.array_equal(terms["error"], found.error)
    total = 5.08 + terms["p"] + terms["i"] + terms["d"] + terms["feedforward"]
    np.testing.assert_allclose(found.voltage, np.clip(total, 0.0, 10.0), rtol=1e-14)
    assert np.ptp(terms["p"]) > 1.0


def test_the_terms_of_a_law_are_saved_with_the_run(tmp_path: Path) -> None:
    """The CSV has them behind the columns, without units; the PID's error is the run's own."""
    found = run(PidParameters(), duration=0.1)
    found.save(tmp_path / "run.csv")
    units, names, *rows = (tmp_path / "run.csv").read_text(encoding="utf-8").splitlines()
    assert names.endswith(",mass_flow_b,reference,error,p,i,d,feedforward")
    assert units.endswith(",kg/s,m,m,,,,")
    table = np.array([[float(value) for value in row.split(",")] for row in rows])
    saved = dict(zip(names.split(","), table.T, strict=True))
    for name, values in found.terms.items():
        assert np.array_equal(saved[name], values), name
    assert np.ptp(saved["p"]) > 1.0
    again = found.with_terms({"q": saved["p"]})
    assert list(again.columns())[-3:] == ["reference", "error", "q"]
    assert found.with_terms({}).columns().keys() == found.columns().keys() - {*"pid", "feedforward"}


class Estimate(NamedTuple):
    """A command with the law's own idea of the velocity."""

    voltage: float
    velocity: float


def test_a_term_that_differs_from_the_column_of_its_name_is_saved_beside_it() -> None:
    """The true velocity stays what it is; the law's estimate gets a name of its own."""

    class Estimating(Law):
        TERMS = ("velocity",)

        def update(self, measurement: Measurement, *_: object) -> Estimate:
            return Estimate(5.4, measurement.position)

    found = run(Estimating(), RigParameters(), 0.2)
    columns = found.columns()
    assert list(columns)[-1] == "term_velocity"
    assert found.units()["term_velocity"] == ""
    assert np.array_equal(columns["term_velocity"], found.position)
    assert np.array_equal(columns["velocity"], found.velocity)
    assert not np.array_equal(found.velocity, found.position)


def test_a_law_is_reset_once_before_a_run() -> None:
    """Whether it runs in Python or compiled."""

    def counted(kind: type[Law]) -> int:
        resets = []

        class Counting(kind):  # type: ignore[misc, valid-type]
            def reset(self) -> None:
                resets.append(None)
                super().reset()

        run(Counting(), duration=0.01)
        return len(resets)

    assert [counted(kind) for kind in (Pid, StepwisePid)] == [1, 1]


def test_a_law_that_forgot_its_base_class_is_refused() -> None:
    """Without parameters nobody knows its limits: the error says what to write."""

    class Forgetful(Law):
        def __init__(self) -> None:
            self.gain = 1.0

        def update(self, *_: object) -> float:
            return 5.08

    expected = r"^law Forgetful: __init__ must call super\(\).__init__\(\)$"
    for law in (Forgetful, Forgetful()):
        with pytest.raises(TypeError, match=expected):
            run(law)


def test_a_law_is_given_what_the_instruments_read() -> None:
    """Position and pressures are those of the run, the supply has noise; time, reference too."""
    law = Spied()
    found = run(law, duration=0.1)
    measurements, points, intervals = zip(*law.seen, strict=True)
    assert [m.stamp for m in measurements] == [k * 1_000_000 for k in range(101)]
    for name in ("position", "pressure_a", "pressure_b"):
        assert [getattr(m, name) for m in measurements] == getattr(found, name).tolist()
    supply = np.array([m.supply_pressure for m in measurements])
    assert 50.0 < np.std(supply) < 500.0
    assert abs(np.mean(supply) - NOISY.number("supply.pressure")) < 6e3
    assert [p.position for p in points] == found.reference.tolist()
    assert intervals == (0.0, *[1e-3] * 100)
    # Without noise it would be given the truth.
    true = simulate(NOISY, found.voltage[:-1], 1e-3, position=0.02)
    assert not np.array_equal(true.position, found.position)


def test_each_run_starts_the_law_afresh() -> None:
    """A law that has run before, in Python or compiled, gives the same again."""
    for law in (Pid(), StepwisePid()):
        law.update(Measurement(0, 0.1), ReferencePoint(0.0, 1.0), 0.5)
        assert same(run(law), run(law))


@pytest.mark.slow
def test_a_users_compiled_law_is_the_same_compiled_and_in_python(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A law from a module outside the package, with pressures: compiled and by its update()."""
    (tmp_path / "damped_law.py").write_text(COMPILED, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    damped = importlib.import_module("damped_law").Damped

    class Stepwise(damped):  # type: ignore[misc, valid-type]
        """The same, asked in Python."""

        def update(self, *sample: object) -> object:
            """Ask the compiled law."""
            return super().update(*sample)

    gentle = {"mine.gain": 60.0}
    found = run(damped(gentle))
    assert same(found, run(Stepwise(gentle)))
    assert not same(found, run(damped()))
    assert np.array_equal(found.terms["force"], found.pressure_a - found.pressure_b)
    undamped = run(damped({"mine.gain": 60.0, "mine.damping": 0.0}))
    assert not np.array_equal(undamped.voltage, found.voltage)


def test_commands_are_kept_within_the_output_limits() -> None:
    """A plain law's wild voltages reach the valve as controller.maximum_voltage allows."""

    class Wild(Law):
        def update(self, measurement: Measurement, *_: object) -> float:
            return 1e3 if measurement.time < 0.05 else -1e3

    found = run(Wild({"controller.minimum_voltage": 4.0, "controller.maximum_voltage": 7.0}))
    assert set(found.voltage) == {4.0, 7.0}
    found = run(Wild)
    assert set(found.voltage) == {0.0, 10.0}


class Pair(NamedTuple):
    """A command of another law's shape."""

    voltage: float
    other: float


@pytest.mark.parametrize("value", [math.nan, math.inf, None, "5.08", (5.0, 1.0), Pair(5.0, 1.0)])
def test_what_is_no_command_stops_the_run_by_name(value: object) -> None:
    """The error names the law, the time and the value."""

    def strange(measurement: Measurement, _reference: ReferencePoint) -> object:
        return value if measurement.time >= 0.02 else 5.08

    with pytest.raises(ValueError, match=re.escape(repr(value))) as error:
        run(strange)
    assert str(error.value).startswith("at 0.02 s: law strange answered ")
    assert "\n" not in str(error.value)


def test_a_compiled_law_that_is_not_finite_stops_the_run_by_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In the compiled loop too, at the sample where it happens."""
    text = COMPILED.replace("5.08 +", "(5.08 if reference.position < 0.03 else 1.0 / 0.0) +")
    (tmp_path / "broken_law.py").write_text(text, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    broken = importlib.import_module("broken_law").Damped
    with pytest.raises(ValueError, match=r"^at 0\.05 s: law Damped answered inf V") as error:
        run(broken())
    assert "\n" not in str(error.value)


def test_what_a_law_raises_comes_out_as_it_is() -> None:
    """A user sees the own exception, with the own line in its traceback."""
    with pytest.raises(ZeroDivisionError):
        run(lambda m, r: m.position / (r.position - r.position))


@pytest.mark.parametrize("law", [3, "pid", object, None])
def test_what_is_no_law_at_all_is_refused(law: object) -> None:
    """The message says what may be given."""
    with pytest.raises(TypeError, match="is no control law: give a Law"):
        run(law)


def test_a_law_with_an_uncompiled_kernel_is_refused() -> None:
    """The class says which function lacks the decorator."""
    kernels = Pid.KERNELS._replace(begin=Pid.KERNELS.begin.py_func)
    with pytest.raises(TypeError, match=r"KERNELS\.begin is not compiled"):
        type("Half", (CompiledLaw,), {"KERNELS": kernels})


def test_a_parameter_that_two_share_is_declared_once() -> None:
    """A law without parameters of its own has the output limits alone."""

    class Bare(Law):
        PARAMETERS = declare(Parameter("bare.on", True, "", "whether", "none"))

    assert list(Bare.Parameters()) == [
        "bare.on",
        "controller.neutral_voltage",
        "controller.minimum_voltage",
        "controller.maximum_voltage",
    ]
    assert len(Law.Parameters()) == 3


CACHED = """
from rodless_control import Pid, PidParameters, references
from rodless_lab import closed_loop
from rodless_lab.simulation.closed_loop import compiled_loop
from rodless_sim import RigParameters
closed_loop(RigParameters(), PidParameters(), references.constant(0.0), 0.01, 1e-3)
stats = compiled_loop(Pid.KERNELS).stats
print(sum(stats.cache_hits.values()), sum(stats.cache_misses.values()))
"""


@pytest.mark.slow
def test_the_loop_of_a_law_of_the_package_is_kept_between_processes() -> None:
    """Another process loads the loop from the cache that this one has filled."""
    run(PidParameters())
    assert compiled_loop(Pid.KERNELS) is compiled_loop(Pid.KERNELS)
    done = subprocess.run(
        [sys.executable, "-c", CACHED], capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == ["1", "0"]


@pytest.mark.slow
def test_the_loop_of_a_law_from_elsewhere_is_not_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nobody watches the sources of a user's law: two of the same names give their own numbers."""
    found = []
    for folder, gain in (("first", "1.0 *"), ("second", "2.0 *")):
        (tmp_path / folder).mkdir()
        text = COMPILED.replace("gains.gain *", f"{gain} gains.gain *")
        (tmp_path / folder / "changing_law.py").write_text(text, encoding="utf-8")
        monkeypatch.syspath_prepend(tmp_path / folder)
        monkeypatch.delitem(sys.modules, "changing_law", raising=False)
        law = importlib.import_module("changing_law").Damped
        found.append(run(law({"mine.gain": 40.0})))
        assert compiled_loop(law.KERNELS).stats.cache_path is None
    assert compiled_loop(Pid.KERNELS).stats.cache_path is not None
    assert not np.array_equal(found[0].voltage, found[1].voltage)
