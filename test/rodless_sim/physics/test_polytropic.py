# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The chambers' air with an exponent of its own: isothermal and adiabatic limits in closed form."""

import math

import numpy as np
import pytest

from rodless_sim import ParameterError, RigParameters, simulate
from rodless_sim.physics.motion import advance
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings
from rodless_sim.physics.state import Motion

AREA, DEAD_VOLUME, STROKE = math.pi / 4.0 * 0.025**2, 15e-6, 0.2
GAS, TEMPERATURE = 287.05, 297.0


def polytropic(index: float, **others: object) -> RigParameters:
    values = {name.replace("__", "."): value for name, value in others.items()}
    chosen = {"chambers.thermodynamics": "polytropic", "chambers.polytropic_index": index}
    return RigParameters({**chosen, **values})


def thrown(plant: Plant) -> list[Motion]:
    """States of a sealed rig whose carriage is thrown, every 100 µs."""
    states = [Motion(0.1, 0.5, 4e5, 4e5)]
    for _ in range(500):
        states.append(advance(plant, openings(plant, 5.08), states[-1], 1e-4, 1.0)[0])
    return states


@pytest.mark.parametrize("index", [1.0, 1.2, 1.4])
def test_a_sealed_chamber_keeps_pressure_times_volume_to_the_index(index: float) -> None:
    """P Vⁿ of both chambers stays: Boyle's law for n = 1, the adiabat for n = κ."""
    plant = Plant.of(polytropic(index, valve__gap_height=0.0))
    states = thrown(plant)
    middle = DEAD_VOLUME + AREA * 0.1
    for state in states:
        volume_a = DEAD_VOLUME + AREA * state.position
        volume_b = DEAD_VOLUME + AREA * (STROKE - state.position)
        assert state.pressure_a == pytest.approx(4e5 * (middle / volume_a) ** index, rel=1e-6)
        assert state.pressure_b == pytest.approx(4e5 * (middle / volume_b) ** index, rel=1e-6)
    assert abs(states[-1].position - 0.1) > 5e-5


def test_an_isothermal_chamber_holds_the_air_let_in() -> None:
    """With n = 1, P V/(R T) grows by ∫ ṁ dt: filling by the valve, the carriage locked."""
    parameters = polytropic(1.0, cylinder__locked=True)
    run = simulate(parameters, [6.0] * 20_000, 2e-5, 0.1)
    mass = run.pressure_a * (DEAD_VOLUME + AREA * 0.1) / (GAS * TEMPERATURE)
    let_in = np.sum(0.5 * (run.mass_flow_a[1:] + run.mass_flow_a[:-1])) * 2e-5
    assert mass[-1] - mass[0] == pytest.approx(let_in, rel=1e-6)
    assert let_in > 1e-5


@pytest.mark.parametrize("index", [1.0, 1.25])
def test_choked_filling_takes_the_index_as_a_factor(index: float) -> None:
    """From vacuum, nearly, a choked valve raises P by n R T ṁ/V a second: linear, by hand.

    At 6 V the reconciled orifice has C_v S = 0.21843 mm²: 0.684731 P S/√(RT) of 621325 Pa is
    3.1827e-4 kg/s.
    """
    parameters = polytropic(index, cylinder__locked=True, valve__gap_height=0.0)
    run = simulate(parameters, [6.0] * 20, 1e-3, 0.1, (1.5e5, 1.5e5))
    rate = (run.pressure_a[-1] - run.pressure_a[0]) / run.time[-1]
    volume = DEAD_VOLUME + AREA * 0.1
    assert rate == pytest.approx(index * GAS * TEMPERATURE * 3.1827e-4 / volume, rel=1e-4)


def test_the_index_of_the_gas_gives_the_rig_of_the_paper() -> None:
    """With n = κ a run is that of the adiabatic chambers to the last bit; other n change it."""
    volts = [6.0] * 300
    adiabatic = simulate(RigParameters(), volts, 1e-3, 0.05)
    assert np.array_equal(simulate(polytropic(1.4), volts, 1e-3, 0.05).position, adiabatic.position)
    assert np.ptp(simulate(polytropic(1.2), volts, 1e-3, 0.05).position - adiabatic.position) > 1e-6


def test_an_index_above_that_of_the_gas_is_refused() -> None:
    """Where it is in use: compressed air would take heat up. Adiabatic chambers do not ask."""
    with pytest.raises(ParameterError, match=r"^chambers\.polytropic_index: 1\.5 refused, above"):
        polytropic(1.5)
    RigParameters({"chambers.polytropic_index": 1.5})
    RigParameters({"air.isentropic_index": 1.1})
