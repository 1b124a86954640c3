# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.


"""Equations that a rig has not had before: known to be missing, and compiled ahead of time."""

import os
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import numba
import pytest

from rodless_base.parameters import ParameterError
from rodless_sim import Rig, RigParameters, Scenario
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.timed import memory_like, memory_of
from rodless_sim.rig import kinds_of, with_states_of

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
    """Of all parameters that may change, at their largest: those of OPTIONS alone."""
    base = RigParameters()
    found = set()
    for name, declared in base.DECLARATIONS.items():
        values = declared.choices or (declared.maximum, 1e-6)
        for value in () if declared.fixed else values:
            with suppress(ParameterError):
                rig = base.with_values({name: value})
                if kinds_of(Plant.of(rig)) != kinds_of(Plant.of(base)):
                    found.add(name)
    assert found == {name for option in OPTIONS for name in option}


@pytest.mark.parametrize("option", OPTIONS, ids=lambda option: next(iter(option)))
def test_a_rig_knows_that_it_has_its_equations(option: dict[str, object]) -> None:
    """What a rig has been configured for is there, for another rig too."""
    rig, values = Rig(), RigParameters(option)
    rig.configure(values)
    assert rig.has_equations_for(values)
    assert rig.has_equations_for(RigParameters())
    assert Rig().has_equations_for(values)


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


IN_A_NEW_PROCESS = """
from rodless_sim import RigParameters, Scenario
from rodless_sim.node.engine import Engine
from rodless_sim.physics.motion import advance_at_voltage

engine = Engine(
    RigParameters(),
    lambda seen, state: None,
    Scenario(
        [
            (0.01, {"supply.droop": 1e4}),
            (0.02, {"supply.droop": 0.0, "supply.ripple_amplitude": 1e3}),
        ]
    ),
)
there = set(advance_at_voltage.overloads)
assert len(there) == 3, there
for _ in range(30):
    engine.step()
assert len(engine.rig.played) == 2 and not engine.failure
assert set(advance_at_voltage.overloads) == there
"""


def test_a_plant_has_the_equations_of_its_scenario_before_time_runs() -> None:
    """In a process of its own: nothing is loaded or compiled on the way."""
    subprocess.run([sys.executable, "-c", IN_A_NEW_PROCESS], check=True, timeout=300)


@pytest.mark.slow
def test_compiling_for_others_ends_with_who_wants_it(tmp_path: Path) -> None:
    """Long before it is done, once its standard input ends."""
    with subprocess.Popen(
        [sys.executable, "-m", "rodless_sim.precompile"],
        stdin=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env={**os.environ, "XDG_CACHE_HOME": str(tmp_path)},
        text=True,
    ) as process:
        assert process.stdin is not None
        assert process.stderr is not None
        print('[{}, {"supply.droop": 1e4}]', file=process.stdin, flush=True)
        assert process.stderr.readline().startswith("compiling")
        process.stdin.close()
        assert process.wait(60) == 1
        assert process.stderr.read() == ""
