# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.


"""Equations that a rig has not had before: known to be missing, and compiled ahead of time."""

import copy
import errno
import os
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import numba
import pytest
from ended import ended
from extent import some_of

from rodless_base.parameters import ParameterError
from rodless_base.ros.parameters import NotYetError
from rodless_sim import Rig, RigParameters, Scenario
from rodless_sim.node import equations
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.timed import memory_like, memory_of
from rodless_sim.precompile import compile_changes, compile_elsewhere
from rodless_sim.rig import SWITCHES, equations_are_kept, kinds_of, with_states_of

# Of what gives a rig other equations, what can change while it runs.
OPTIONS: tuple[dict[str, object], ...] = (
    {"supply.droop": 1e4},
    {"supply.ripple_amplitude": 1e3},
)

KINDS: tuple[dict[str, object], ...] = (
    {},
    *OPTIONS,
    {"valve.dynamics": "second_order"},
    {"tubes.model": "delay"},
    {"tubes.model": "delay", "valve.dynamics": "second_order"},
    {"tubes.model": "delay", "supply.droop": 1e4},
)

PERIOD = 1e-3


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: " ".join(kind) or "paper")
def test_the_type_of_a_memory_is_known_before_anything_is_compiled(kind: dict[str, object]) -> None:
    """What stands for it has the type that numba gives to the rig's own."""
    plant = Plant.of(RigParameters(kind))
    memory = memory_of(plant, with_states_of(plant, Rig().motion), 5.0)
    assert numba.typeof(memory_like(plant)) == numba.typeof(memory)


def test_no_other_option_changes_the_equations_while_a_rig_runs() -> None:
    """Of all parameters that may change, at their largest: the switches alone."""
    base = RigParameters()
    found = set()
    for name, declared in base.DECLARATIONS.items():
        values = declared.choices or (declared.maximum, 1e-6)
        for value in () if declared.fixed else values:
            with suppress(ParameterError):
                rig = base.with_values({name: value})
                if kinds_of(Plant.of(rig)) != kinds_of(Plant.of(base)):
                    found.add(name)
    assert found == set(SWITCHES)


@pytest.mark.parametrize("option", OPTIONS, ids=lambda option: next(iter(option)))
def test_what_a_rig_has_compiled_is_known(option: dict[str, object]) -> None:
    """What a rig has been configured for is there, for every rig."""
    rig, values = Rig(), RigParameters(option)
    rig.configure(values)
    assert equations_are_kept(values)
    assert equations_are_kept(RigParameters())


def test_a_rigid_rig_with_all_states_has_its_piston_where_its_carriage_is() -> None:
    """Only magnets part them: a stroke that ends behind both is taken, wherever they began."""
    rig = Rig(RigParameters({"supply.droop": 1e4}))
    rig.reset(position=0.15)
    while rig.state.position > 0.05:
        rig.advance(3.0, PERIOD)
    rig.configure(rig.parameters.with_values({"cylinder.stroke": 0.1}))
    assert rig.plant.cylinder.stroke == 0.1


# What a rig with heat, or with tubes, remembers beside position, velocity and pressures.
REMEMBERED: tuple[dict[str, object], ...] = (
    {"chambers.thermodynamics": "energy_balance"},
    {"tubes.model": "delay", "tubes.length": 1.0},
)


@pytest.mark.parametrize("kind", REMEMBERED, ids=lambda kind: next(iter(kind)))
def test_droop_switched_while_the_carriage_moves_loses_no_heat_and_no_air(
    kind: dict[str, object],
) -> None:
    """On and at once off again is nothing at all: the run goes on as that of a twin.

    To what the solver leaves, which begins a step there. A droop of next to nothing changes next to
    nothing, whether it is switched on or off.
    """
    values = RigParameters(kind)
    drooping = values.with_values({"supply.droop": 1e-3})
    rig, twin = Rig(values), Rig(values)
    for one in (rig, twin):
        for _ in range(60):
            one.advance(8.0, PERIOD)
    rig.configure(drooping)
    rig.configure(values)
    assert tuple(rig.state) == pytest.approx(tuple(twin.state), rel=1e-12)
    for changed in (values, drooping, values):
        rig.configure(changed)
        for _ in range(30):
            here, there = rig.advance(8.0, PERIOD), twin.advance(8.0, PERIOD)
        assert here.position == pytest.approx(there.position, abs=1e-8)
        assert here.pressure_a == pytest.approx(there.pressure_a, rel=1e-6)
        assert here.pressure_b == pytest.approx(there.pressure_b, rel=1e-6)


@pytest.mark.parametrize("option", OPTIONS, ids=lambda option: next(iter(option)))
def test_a_reset_takes_the_equations_of_the_start_again(option: dict[str, object]) -> None:
    """After a scenario that has switched an option on: the run is the same once more."""
    rig = Rig(scenario=Scenario([(0.05, option)]))
    first = [rig.advance(6.0, PERIOD) for _ in range(100)]
    rig.reset()
    assert rig.parameters == RigParameters()
    assert [rig.advance(6.0, PERIOD) for _ in range(100)] == first
    other = Rig()
    assert [other.advance(6.0, PERIOD) for _ in range(49)] == first[:49]


@pytest.mark.parametrize("option", OPTIONS, ids=lambda option: next(iter(option)))
def test_a_reset_that_is_interrupted_leaves_the_rig_as_it_was(
    option: dict[str, object], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ctrl-C while it takes its equations: the run goes on as that of a copy does."""
    rig = Rig(scenario=Scenario([(0.05, option)]))
    for _ in range(60):
        rig.advance(6.0, PERIOD)
    twin = copy.copy(rig)

    def interrupt(*_arguments: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("rodless_sim.rig.specialise", interrupt)
        with pytest.raises(KeyboardInterrupt):
            rig.reset()
    assert rig.parameters == twin.parameters
    assert rig.played == twin.played
    assert [rig.advance(6.0, PERIOD) for _ in range(20)] == [
        twin.advance(6.0, PERIOD) for _ in range(20)
    ]


IN_A_NEW_PROCESS = """
from rodless_base.kernel_cache import KernelCache
from rodless_sim import RigParameters, Scenario
from rodless_sim.node.engine import Engine
from rodless_sim.node.equations import Equations

loaded = []
load = KernelCache.load_overload

def noted(cache, *arguments):
    loaded.append(cache)
    return load(cache, *arguments)

KernelCache.load_overload = noted
equations = Equations(print)
"""

SCENARIO = """
parameters = RigParameters()
scenario = Scenario([(0.01, {"supply.droop": 1e4}), (0.02, {"supply.droop": 0.0})])
engine = Engine(parameters, lambda seen, state: None, scenario)
equations.load(parameters, engine.rig.ahead(parameters))
engine.rig.free_air_flow
assert loaded
loaded.clear()
for _ in range(30):
    engine.step()
    engine.rig.free_air_flow
assert len(engine.rig.played) == 2 and not engine.failure
engine.reset()
"""

LIVE = """
engine = Engine(RigParameters(), lambda seen, state: None)
equations.load(engine.rig.parameters, [])
for changes in ({"supply.droop": 1e4}, {"supply.droop": 0.0, "supply.ripple_amplitude": 1e3}):
    loaded.clear()
    equations.require(engine.rig, changes)
    assert loaded
    loaded.clear()
    engine.change(changes)
    engine.step()
    engine.rig.free_air_flow
    assert not loaded, changes
engine.reset()
"""

# Ripple alone is what a reset makes of it.
LIVE_BEFORE_A_RESET = """
scenario = Scenario([(0.01, {"supply.droop": 1e4})])
engine = Engine(RigParameters(), lambda seen, state: None, scenario)
equations.load(engine.rig.parameters, engine.rig.ahead(engine.rig.parameters))
for _ in range(20):
    engine.step()
equations.require(engine.rig, {"supply.ripple_amplitude": 1e3})
loaded.clear()
engine.change({"supply.ripple_amplitude": 1e3})
engine.step()
engine.reset()
engine.step()
"""


LEAK = """
import sys
change = {"fault.piston.leak": 1e-7}
scenario = Scenario([(0.01, change)]) if BY_A_SCENARIO else None
engine = Engine(RigParameters(), lambda seen, state: None, scenario)
assert "scipy.optimize" not in sys.modules
if BY_A_SCENARIO:
    equations.load(engine.rig.parameters, engine.rig.ahead(engine.rig.parameters))
else:
    equations.require(engine.rig, change)

def of_scipy():
    return {name for name in sys.modules if name.startswith("scipy")}

before = of_scipy()
if not BY_A_SCENARIO:
    engine.change(change)
for _ in range(20):
    engine.step()
engine.reset()
assert engine.rig.parameters["fault.piston.leak"] == (0.0 if BY_A_SCENARIO else 1e-7)
assert "scipy.optimize" in before and of_scipy() == before
"""


@pytest.mark.usefixtures("compiled")
@pytest.mark.parametrize("by", [False, True], ids=["live", "scenario"])
def test_a_reset_of_a_plant_in_motion_loads_no_modules(by: bool) -> None:
    """Chambers that leak into each other settle by an optimizer: it is there before."""
    code = f"BY_A_SCENARIO = {by}\n{IN_A_NEW_PROCESS}{LEAK}"
    subprocess.run([sys.executable, "-c", code], check=True, timeout=300)


@pytest.mark.usefixtures("compiled")
@pytest.mark.parametrize("what", some_of([SCENARIO, LIVE, LIVE_BEFORE_A_RESET], 2))
def test_a_plant_in_motion_loads_nothing(what: str) -> None:
    """All that a scenario or a change wants is there before: in a process of its own."""
    code = f"{IN_A_NEW_PROCESS}{what}assert not loaded\n"
    subprocess.run([sys.executable, "-c", code], check=True, timeout=300)


def test_compiling_ahead_does_not_care_where_the_carriage_starts() -> None:
    """A shorter stroke beside the option: the rig that is compiled for is not that of the run."""
    before = RigParameters({"cylinder.initial_position": 0.1})
    changes = {"cylinder.initial_position": 0.04, "cylinder.stroke": 0.05, "supply.droop": 1e4}
    compile_changes(before, [before.with_values(changes)])


@pytest.fixture
def compiled() -> None:
    """Compile what the new processes load."""
    compile_changes(RigParameters(), map(RigParameters, OPTIONS))


def test_what_cannot_be_compiled_elsewhere_is_said_and_refused_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Whatever the other process says: nothing is kept. Then the plant does it itself."""
    monkeypatch.setattr(equations, "is_compiled", lambda _: False)
    monkeypatch.setattr(
        equations, "compile_elsewhere", lambda *_: ended("raise SystemExit('no room')")
    )
    said: list[str] = []
    tried, rig, droop = equations.Equations(said.append), Rig(), {"supply.droop": 1e4}
    tried.load(rig.parameters, [])
    for changes in (droop, {"supply.ripple_amplitude": 1e3}):
        with pytest.raises(NotYetError, match=rf"^{next(iter(changes))} wants other equations"):
            tried.require(rig, changes)
    tried.poll()
    assert said[1:] == ["supply.droop: not compiled: no room"]
    with pytest.raises(ParameterError, match=r"could not compile .* \(no room\); set again") as one:
        tried.require(rig, droop)
    assert not isinstance(one.value, NotYetError)
    tried.require(rig, droop)
    tried.require(rig, {"supply.pressure": 6e5})


def test_what_was_not_compiled_keeps_no_other_change_back(monkeypatch: pytest.MonkeyPatch) -> None:
    """A failure is told to whoever sets what failed, and to nobody else."""
    monkeypatch.setattr(equations, "is_compiled", lambda _: False)
    monkeypatch.setattr(equations, "compile_changes", lambda *_: None)
    monkeypatch.setattr(
        equations, "compile_elsewhere", lambda *_: ended("raise SystemExit('no room')")
    )
    tried, rig = equations.Equations(lambda _: None), Rig()
    tried.load(rig.parameters, [])
    droop, ripple = {"supply.droop": 1e4}, {"supply.ripple_amplitude": 1e3}
    with pytest.raises(NotYetError):
        tried.require(rig, droop)
    tried.poll()
    monkeypatch.setattr(equations, "is_compiled", lambda _: True)
    tried.require(rig, ripple)
    with pytest.raises(ParameterError, match="no room"):
        tried.require(rig, droop)


def test_without_another_process_the_change_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """By a reason, and not as a failure of the plant."""

    def none(*_arguments: object) -> None:
        raise OSError(errno.EAGAIN, os.strerror(errno.EAGAIN))

    monkeypatch.setattr(equations, "is_compiled", lambda _: False)
    monkeypatch.setattr(equations, "compile_elsewhere", none)
    tried = equations.Equations(lambda _: None)
    with pytest.raises(ParameterError, match=r"^supply\.droop: refused, no process .*unavailable"):
        tried.require(Rig(), {"supply.droop": 1e4})


def test_the_other_process_has_the_modules_of_this_one(tmp_path: Path) -> None:
    """Where they are is part of where compiled code is kept: not those where the plant runs."""
    (tmp_path / "rodless_sim").mkdir()
    (tmp_path / "rodless_sim" / "__init__.py").write_text("raise SystemExit('another one')")
    code = """
from rodless_sim import RigParameters
from rodless_sim.precompile import compile_elsewhere
print(compile_elsewhere(RigParameters(), []).communicate()[1])
"""
    without = {k: v for k, v in os.environ.items() if k != "PYTHONSAFEPATH"}
    done = subprocess.run(
        [sys.executable, "-I", "-c", code],
        cwd=tmp_path,
        env=without,
        capture_output=True,
        text=True,
        check=True,
        timeout=300,
    )
    assert done.stdout == "\n"


@pytest.mark.slow
def test_compiling_for_others_ends_with_who_wants_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Long before it is done, once its standard input ends."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    with compile_elsewhere(RigParameters(), map(RigParameters, OPTIONS)) as process:
        assert process.stdin is not None
        assert process.stderr is not None
        assert process.stderr.readline().startswith("compiling")
        process.stdin.close()
        assert process.wait(60) == 1
        assert process.stderr.read() == ""
