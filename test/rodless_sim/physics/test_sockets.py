# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A friction form, an assembly of the valve, a force: each is one new file plus one line."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest
from unmeasured import unmeasured

import rodless_base
import rodless_sim
from rodless_sim import RigParameters
from rodless_sim.physics import forces

COULOMB = """
from rodless_base.kernels import kernel
from rodless_base.parameters import Parameter, ParameterError, declare
from rodless_sim.physics.friction_forms.direction import Drag

NAME = "coulomb"
MEANING = "the same force at any speed"
PARAMETERS = declare(
    Parameter("friction.dry", 20.0, "N", "force at any speed", "test", 0.0, 1e3)
)


def check(parameters):
    if parameters.number("friction.dry") > 50.0:
        raise ParameterError("friction.dry: above what this seal bears")


def of(parameters):
    return (parameters.number("friction.dry"),)


@kernel
def force(constants, side, speed):
    return Drag(constants[0], 0.0)
"""

ORIFICE = """
from rodless_base.kernels import kernel
from rodless_base.parameters import Parameter, ParameterError, declare
from rodless_sim.physics.flow import Flow
from rodless_sim.physics.lands import Edge, Lands

NAME = "orifice"
MEANING = "an orifice alone, its area in proportion to the voltage"
PARAMETERS = declare(
    Parameter("valve.area_gain", 1e-7, "m²/V", "area per volt", "test", 0.0, 1e-5)
)


def check(parameters):
    if parameters.number("valve.area_gain") == 0.0:
        raise ParameterError("valve.area_gain: the valve never opens")


def of(parameters):
    return (parameters.number("valve.area_gain"),)


@kernel
def lands(constants, air, valve, voltage):
    deflection = voltage - valve.closed_voltage
    return Lands(deflection >= 0.0, Edge(constants[0] * abs(deflection), 0.0), Edge(0.0, 0.0))


@kernel
def gap(constants, air, edge, pressure_1, pressure_2):
    return Flow(0.0, 0.0, 0.0)
"""

TILT = """
import math
from rodless_base.kernels import kernel
from rodless_base.parameters import Parameter, ParameterError, declare
from rodless_sim.physics.force import Force

PARAMETERS = declare(
    Parameter("slope.angle", 0.0, "rad", "slope under the rail, B's end up", "test", -1.6, 1.6)
)


def check(parameters):
    if parameters.number("slope.angle") > parameters.number("cylinder.moving_mass"):
        raise ParameterError("slope.angle: too steep for this carriage")


def of(parameters):
    angle = parameters.number("slope.angle")
    return (9.81 * parameters.number("cylinder.moving_mass") * math.sin(angle),)


@kernel
def force(constants, state):
    return Force(-constants[0], 0.0, 0.0)
"""

PROGRAM = """
import json, sys
from rodless_sim import RigParameters
from rodless_sim.physics.friction import sliding_friction
from rodless_sim.physics.equations import net_force
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import edge_flow, openings
from rodless_sim.physics.state import Motion

plant = Plant.of(RigParameters(json.loads(sys.argv[1])))
edge = openings(plant, 6.08).opening
found = {
    "friction": [sliding_friction(plant.friction, v, d) for v, d in ((-0.01, -1), (0.4, 1))],
    "force": [net_force(plant, Motion(y, 0.0, 3e5, 3e5)) for y in (0.1, 0.2)],
    "valve": [edge.orifice_area, edge_flow(plant, edge, 7e5, 1e5)],
}
print(json.dumps(found))
"""


@pytest.fixture
def extended(tmp_path: Path) -> Path:
    """Return a copy of the packages with three files and three lines more."""
    for package in (rodless_base, rodless_sim):
        source = Path(package.__file__).parent
        shutil.copytree(source, tmp_path / source.name)
    config = Path(rodless_base.__file__).parents[1] / "config"
    if config.is_dir():
        shutil.copytree(config, tmp_path / "config")
    physics = tmp_path / "rodless_sim" / "physics"
    for file, text in (
        ("friction_forms/coulomb.py", COULOMB),
        ("valve_assemblies/orifice.py", ORIFICE),
        ("tilt.py", TILT),
    ):
        (physics / file).write_text(text, encoding="utf-8")
    for file, line, longer in (
        ("friction.py", '"saturating",', '"saturating", "coulomb",'),
        ("valve_assembly.py", '"printed",', '"printed", "orifice",'),
        ("forces.py", '("rail",)', '("rail", "tilt")'),
    ):
        path = physics / file
        text = path.read_text(encoding="utf-8")
        assert text.count(line) == 1
        path.write_text(text.replace(line, longer), encoding="utf-8")
    return tmp_path


def started(folder: Path, **parameters: object) -> "subprocess.CompletedProcess[str]":
    """Run the program on the extended plant, as plain Python."""
    environment = {
        **unmeasured(),
        "NUMBA_DISABLE_JIT": "1",
        "PYTHONPATH": os.pathsep.join([str(folder), *(path for path in sys.path if path)]),
    }
    values = {name.replace("__", "."): value for name, value in parameters.items()}
    return subprocess.run(
        [sys.executable, "-c", PROGRAM, json.dumps(values)],
        env=environment,
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )


def found(folder: Path, **parameters: object) -> dict[str, list[float]]:
    """What the extended plant gives."""
    done = started(folder, **parameters)
    assert done.returncode == 0, done.stderr
    result: dict[str, list[float]] = json.loads(done.stdout)
    return result


@pytest.mark.slow
def test_a_friction_form_an_assembly_and_a_force_are_a_file_and_a_line_each(extended: Path) -> None:
    """Chosen, each gives what it says; not chosen, all is as before.

    Tilted by 30° the carriage of 2 kg is drawn back by 2 · 9.81 / 2 N.
    """
    before = found(extended)
    assert before["friction"][1] == pytest.approx(12.0 + 4500.0 * 0.4)
    assert before["force"] == [0.0, 0.0]
    after = found(
        extended,
        friction__form="coulomb",
        friction__dry=21.5,
        valve__assembly="orifice",
        valve__area_gain=2e-7,
        slope__angle=0.5235987755982988,
        cylinder__moving_mass=2.0,
    )
    assert after["friction"] == [-21.5, 21.5]
    assert after["force"] == pytest.approx([-9.81, -9.81])
    assert after["valve"][0] == pytest.approx(2e-7)
    # Choked: 0.684731 P S / sqrt(R T).
    assert after["valve"][1] == pytest.approx(0.684731 * 7e5 * 2e-7 / 291.9826, rel=1e-5)
    assert after["valve"] != before["valve"]


def a_force(text: str) -> ModuleType:
    """Return a module with a force of its own, written as Python."""
    module = ModuleType("wind")
    exec(text, module.__dict__)
    return module


GUST = """
from rodless_sim.physics.force import Force
def of(parameters):
    return parameters.number("cylinder.moving_mass")
def force(mass, state):
    return Force(mass * state.velocity, 0.0, mass)
"""


def test_a_force_of_another_type_is_refused_by_name(monkeypatch: pytest.MonkeyPatch) -> None:
    """A plain tuple is, and a whole number among its parts, beside a sound one.

    The compiler would name neither module nor function.
    """
    parameters = RigParameters({"cylinder.moving_mass": 2.0})
    sound = a_force(GUST)
    for wrong in ("mass * state.velocity, 0.0, mass", "Force(0, 0.0, mass)"):
        odd = a_force(GUST.replace("Force(mass * state.velocity, 0.0, mass)", wrong))
        monkeypatch.setattr(forces, "FORCES", (sound, odd))
        with pytest.raises(TypeError, match=r"^wind: force returns .*, but must return a Force"):
            forces.of(parameters)
    monkeypatch.setattr(forces, "FORCES", (sound, a_force(GUST)))
    assert forces.of(parameters) == (2.0, 2.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("values", "refusal"),
    [
        ({"friction__dry": 60.0}, "friction.dry: above what this seal bears"),
        ({"valve__area_gain": 0.0}, "valve.area_gain: the valve never opens"),
        ({"slope__angle": 1.5}, "slope.angle: too steep for this carriage"),
    ],
    ids=["friction form", "assembly", "force"],
)
def test_a_new_module_may_refuse_values(
    extended: Path, values: dict[str, object], refusal: str
) -> None:
    """Its check() is called with the whole set, and its error comes out as it is."""
    done = started(extended, cylinder__moving_mass=1.0, **values)
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1].endswith(f"ParameterError: {refusal}")
