# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The magnets between piston and carriage: oscillation, energy, parting and catching again."""

import math

import numpy as np
import pytest

from rodless_base.kernels import specialise
from rodless_base.parameters import ParameterError
from rodless_sim import Rig, RigParameters, simulate
from rodless_sim.cylinder_series import BORES, values_of
from rodless_sim.faults import cleared
from rodless_sim.physics.motion import advance_at_voltage
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.state import FullMotion
from rodless_sim.rig import starting_motion

HOLDING, SLIP, CATCH = 363.0, 3e-3, 1.5e-3
PISTON, CARRIAGE = 0.35, 0.65  # kg
AREA = math.pi * 0.025**2 / 4.0
MAGNETIC: dict[str, object] = {"coupling.kind": "magnetic"}
NO_FRICTION = {
    f"friction.{side}.{what}": 0.0
    for side in ("forward", "reverse")
    for what in ("static", "coulomb", "viscous")
}
# Chambers so large that their air is no spring, and nothing that damps.
FREE = {
    **MAGNETIC,
    **NO_FRICTION,
    "friction.capture_velocity": 0.0,
    "coupling.damping": 0.0,
    "cylinder.dead_volume_a": 1e-2,
    "cylinder.dead_volume_b": 1e-2,
}


def released(
    values: dict[str, object],
    lag: float,
    pressures: tuple[float, float],
    voltage: float,
    samples: int,
    period: float,
) -> list[FullMotion]:
    """The states from rest at mid-stroke on, the piston ``lag`` (m) ahead; tolerance 0.01."""
    parameters = RigParameters(values)
    plant = Plant.of(parameters)
    motion = starting_motion(plant, parameters, 0.1, pressures)
    assert isinstance(motion, FullMotion)
    motion = motion._replace(piston_position=0.1 + lag)
    advance = specialise(advance_at_voltage, plant, (), voltage, motion, period, 0.01)
    found = [motion]
    for _ in range(samples):
        motion, _, _, _, fault = advance(plant, (), voltage, motion, period, 0.01)
        assert fault == 0
        found.append(FullMotion(*motion))
    return found


def oscillation(amplitude: float, samples: int, period: float) -> list[FullMotion]:
    """Let piston and carriage go with ``amplitude`` (m) between them, the valve closed."""
    return released(FREE, amplitude, (3e5, 3e5), 5.08, samples, period)


def test_small_oscillation_has_the_frequency_of_two_masses_on_a_spring() -> None:
    """ω² = k (1/m_p + 1/m_c), k = F_max π/(2 δ_m) the slope at rest: 145 Hz."""
    period = 1e-4
    lag = np.array([s.piston_position - s.position for s in oscillation(2e-5, 1000, period)])
    omega = math.sqrt(HOLDING * math.pi / (2.0 * SLIP) * (1.0 / PISTON + 1.0 / CARRIAGE))
    expected = 2e-5 * np.cos(omega * period * np.arange(lag.size))
    assert lag == pytest.approx(expected, abs=4e-7)


def energy(state: FullMotion) -> float:
    """Kinetic energy of both, and what the magnets hold, J."""
    lag = state.piston_position - state.position
    held = HOLDING * 2.0 * SLIP / math.pi * (1.0 - math.cos(0.5 * math.pi * lag / SLIP))
    return 0.5 * (PISTON * state.piston_velocity**2 + CARRIAGE * state.velocity**2) + held


def test_undamped_magnets_keep_energy_and_momentum() -> None:
    """A swing of 2 mm, where the spring is far from a line: the same energy after 0.1 s.

    The air of chambers so large takes some millinewtons: 1 % of the momentum.
    """
    states = oscillation(2e-3, 100, 1e-3)
    energies = np.array([energy(state) for state in states])
    assert energies == pytest.approx(energies[0], rel=1e-3)
    momenta = [PISTON * s.piston_velocity + CARRIAGE * s.velocity for s in states]
    swing = max(PISTON * abs(s.piston_velocity) for s in states)
    assert np.abs(momenta).max() < 1e-2 * swing


def test_they_part_at_the_holding_force() -> None:
    """A locked carriage, the push on the piston slowly rising: it leaves at 363 N."""
    values = {**FREE, "cylinder.locked": True, "coupling.damping": 20.0, "supply.pressure": 1.2e6}
    lag = SLIP * 2.0 / math.pi * math.asin(360.0 / HOLDING)
    # The valve a little open: chamber A fills, B empties, some newtons in a second.
    states = released(values, lag, (1.1e6, 1.1e6 - 360.0 / AREA), 6.0, 2000, 2e-3)
    coupled = np.array([state.coupled for state in states])
    pushes = np.array([AREA * (state.pressure_a - state.pressure_b) for state in states])
    parted = int(np.argmin(coupled))
    assert coupled[parted] == 0.0
    assert parted > 20
    assert pushes[0] == pytest.approx(360.0)
    assert pushes[parted] == pytest.approx(HOLDING, abs=1.0)
    assert {state.position for state in states} == {0.1}


def lost_rig() -> Rig:
    """A rig whose carriage has been seized at 50 mm and left by the piston."""
    values = {**MAGNETIC, "coupling.holding_force": 100.0, "fault.carriage.seized": True}
    rig = Rig(RigParameters(values))
    rig.reset(position=0.05)
    state = rig.advance(8.0, 4.0)
    assert state.coupled == 0.0
    assert state.position == 0.05
    assert state.piston_position > 0.15
    return rig


def test_the_piston_catches_the_carriage_again() -> None:
    """It comes back slowly: what it left it takes along, from the catching distance on."""
    rig = lost_rig()
    rig.configure(rig.parameters.with_values(cleared()))
    before = after = rig.state
    for _ in range(8000):
        before, after = after, rig.advance(4.0, 1e-3)
        if after.coupled == 1.0:
            break
    assert after.coupled == 1.0
    assert before.piston_position - before.position >= CATCH
    assert abs(after.piston_position - after.position) <= CATCH
    for _ in range(300):
        after = rig.advance(4.0, 1e-3)
    assert after.coupled == 1.0
    assert after.position < 0.049


def test_a_lost_carriage_stays_where_it_is() -> None:
    """Nothing pulls it: friction stops it, and the piston goes on to the cap."""
    rig = lost_rig()
    rig.configure(rig.parameters.with_values(cleared()))
    state = rig.advance(8.0, 1.0)
    assert state.position == 0.05
    assert state.piston_position == 0.2
    assert state.piston_velocity == 0.0


def test_decoupled_by_a_fault_and_caught_again() -> None:
    """The fault works at once, live; without it the magnets take hold where they are near."""
    rig = Rig(RigParameters(MAGNETIC))
    rig.reset(position=0.1)
    rig.advance(6.0, 0.1)
    rig.configure(rig.parameters.with_values({"fault.carriage.decoupled": True}))
    state = rig.advance(6.0, 0.5)
    assert state.coupled == 0.0
    assert state.piston_position - state.position > 5e-3
    rest = state.position
    assert rig.advance(6.0, 0.2).position == pytest.approx(rest, abs=1e-6)
    rig.configure(rig.parameters.with_values(cleared()))
    for _ in range(3000):
        state = rig.advance(4.0, 1e-3)
    assert state.coupled == 1.0
    assert state.position < rest - 1e-3


def test_a_stroke_that_ends_before_the_parted_piston_is_refused() -> None:
    """It would be thrown back to the new end within a sample; the carriage stands short of that."""
    rig = Rig(RigParameters(MAGNETIC))
    rig.reset(position=0.05)
    rig.configure(rig.parameters.with_values({"fault.carriage.decoupled": True}))
    rig.advance(8.0, 0.3)
    carriage, piston = rig.state.position, rig.state.piston_position
    between = 0.5 * (carriage + piston)
    assert carriage < between < piston
    shorter = rig.parameters.with_values({"cylinder.stroke": between})
    with pytest.raises(ParameterError, match=f"refused, the piston is at {piston:g} m"):
        rig.configure(shorter)
    assert rig.state.piston_position == piston


def test_decoupled_is_refused_where_there_are_no_magnets() -> None:
    """The text says what the rig would need."""
    with pytest.raises(ParameterError, match=r"coupling\.kind is rigid; start .* magnetic"):
        RigParameters({"fault.carriage.decoupled": True})


def test_magnets_that_would_catch_where_they_part_are_refused() -> None:
    """Both distances are named."""
    with pytest.raises(ParameterError, match=r"coupling.catch_distance: 0.003 m .*slip_distance"):
        RigParameters({"coupling.catch_distance": 3e-3})


def test_both_stay_on_the_stroke() -> None:
    """Thrown to and fro at full opening, neither leaves the stroke, and nothing is lost."""
    fast = RigParameters({**MAGNETIC, "friction.form": "saturating"})
    run = simulate(fast, [10.0] * 900 + [0.0] * 900 + [10.0] * 900, 1e-3)
    for place in (run.position, run.piston_position):
        assert 0.0 <= place.min() <= place.max() <= 0.2
        assert np.ptp(place) > 0.19
    assert run.coupled.min() == 1.0
    assert np.abs(run.piston_position - run.position).max() < SLIP


def test_stiff_magnets_are_a_rigid_coupling() -> None:
    """All friction on the piston, a slip of 0.1 mm: the run of one mass but for the lag."""
    values = {
        **MAGNETIC,
        "coupling.holding_force": 1e4,
        "coupling.slip_distance": 1e-3,
        "coupling.catch_distance": 5e-4,
        "coupling.damping": 500.0,
        "coupling.piston_friction": 1.0,
    }
    voltages = [6.5] * 300 + [5.08] * 200
    stiff = simulate(RigParameters(values), voltages, 1e-3, position=0.05)
    rigid = simulate(RigParameters(), voltages, 1e-3, position=0.05)
    assert np.ptp(rigid.position) > 5e-3
    assert stiff.piston_position == pytest.approx(rigid.position, abs=5e-5)


@pytest.mark.parametrize("bore", BORES)
def test_a_model_has_the_holding_force_of_its_bore(bore: int) -> None:
    """Always more than its air can push with at the highest supply of the series, 0.7 MPa."""
    force = values_of(f"CY3R{bore}-200")["coupling.holding_force"]
    assert RigParameters({"cylinder.model": f"CY3R{bore}-200"})["coupling.holding_force"] == force
    assert force > 0.25 * math.pi * (bore * 1e-3) ** 2 * 0.7e6 * 0.95
