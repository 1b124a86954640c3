# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The error-controlled plant against the explicit midpoint rule at half a microsecond."""

import numpy as np
import numpy.typing as npt
import pytest
from midpoint import by_midpoint

from rodless_control import references
from rodless_control.references import Reference
from rodless_lab import closed_loop
from rodless_lab.bare_rigs import BARE_RIGS, bare_pid, bare_rig
from rodless_sim import Rig, RigParameters, simulate

pytestmark = pytest.mark.slow

PERIOD = 1e-3
STEP = references.step(0.0, 0.058, at=0.5)
SINE = references.sine(0.1, 0.02, 0.381, at=0.2)
MAXIMUM = 1.2e6

Array = npt.NDArray[np.float64]


def errors(
    parameters: RigParameters, voltages: Array, position: float, steps: int
) -> tuple[float, float]:
    """Largest difference in position (m) and in either pressure (Pa)."""
    found = simulate(parameters, voltages, PERIOD, position)
    rig = Rig(parameters)
    rig.reset(position)
    expected = by_midpoint(rig.plant, voltages, rig.motion, PERIOD, steps)
    assert np.ptp(expected[:, 0]) > 1e-4
    pressures = np.column_stack([found.pressure_a, found.pressure_b])
    return (
        float(np.abs(found.position - expected[:, 0]).max()),
        float(np.abs(pressures - expected[:, 2:]).max()),
    )


@pytest.mark.parametrize("preset", BARE_RIGS)
@pytest.mark.parametrize(("reference", "start"), [(STEP, 0.0), (SINE, 0.1)], ids=["step", "sine"])
def test_step_and_sine(preset: str, reference: Reference, start: float) -> None:
    """Six seconds of both presets in closed loop: within 1 µm and 100 Pa."""
    parameters = bare_rig(preset)
    run = closed_loop(parameters, bare_pid(preset), reference, 6.0, PERIOD, start)
    position, pressure = errors(parameters, run.voltage[:-1], start, 1000)
    assert position < 1e-6
    assert pressure < 100.0


def friction(**values: float) -> dict[str, object]:
    """The same values in both directions."""
    return {f"friction.{side}.{n}": v for side in ("forward", "reverse") for n, v in values.items()}


STIFF: dict[str, dict[str, object]] = {
    "viscous friction on a light carriage": {
        **friction(viscous=1e5),
        "cylinder.moving_mass": 0.05,
    },
    "little dead volume": {"cylinder.dead_volume_a": 2e-6, "cylinder.dead_volume_b": 2e-6},
    "a steep fall of friction": {
        **friction(static=100.0, coulomb=12.0, stribeck_velocity=1e-4, viscous=500.0),
        "cylinder.moving_mass": 0.05,
    },
    "a light carriage that slams": {
        **friction(static=5.0, coulomb=5.0, viscous=50.0),
        "cylinder.moving_mass": 0.05,
        "end_stop.restitution": 0.9,
    },
    "saturating, very viscous": {
        "friction.form": "saturating",
        **friction(viscous=1e5),
        "friction.high_speed_viscous": 1e5,
    },
    "all at once": {
        **friction(static=100.0, coulomb=12.0, stribeck_velocity=1e-4, viscous=5e3),
        "cylinder.moving_mass": 0.05,
        "cylinder.dead_volume_a": 2e-6,
        "cylinder.dead_volume_b": 2e-6,
        "supply.pressure": MAXIMUM,
    },
}


@pytest.mark.parametrize("changes", STIFF.values(), ids=STIFF.keys())
def test_stiff_corners(changes: dict[str, object]) -> None:
    """Rigs that would need steps far below 20 µs, there and back: within 5 µm and 1 kPa."""
    voltages = np.repeat([6.0, 5.08, 3.5, 7.0], 250)
    position, pressure = errors(RigParameters(changes), voltages, 0.1, 4000)
    assert position < 1e-6
    assert pressure < 100.0


@pytest.mark.parametrize("restitution", [0.0, 0.33, 0.9, 1.0])
def test_slams(restitution: float) -> None:
    """A light, slippery carriage slammed from end to end: within 5 µm and 1 kPa after 0.3 s."""
    parameters = RigParameters(
        {
            **friction(static=5.0, coulomb=5.0, viscous=50.0),
            "cylinder.moving_mass": 0.05,
            "end_stop.restitution": restitution,
        }
    )
    voltages = np.repeat([10.0, 0.0], 150)
    struck = simulate(parameters, voltages, PERIOD, 0.19)
    assert np.count_nonzero(np.diff(np.sign(struck.velocity)) < 0.0) > 1 or restitution == 0.0
    assert struck.position.max() > 0.199
    position, pressure = errors(parameters, voltages, 0.19, 4000)
    assert position < 5e-6
    assert pressure < 1e3
