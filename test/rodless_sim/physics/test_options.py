# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What the paper leaves out, in any combination: a rig comes out all the same."""

from itertools import combinations

import numpy as np
import pytest
from extent import draws, some_of

from rodless_control import references
from rodless_lab import closed_loop
from rodless_lab.bare_rigs import BARE_RIGS, bare_pid, bare_rig
from rodless_sim import RigParameters

# The parameters of each option: a range, or what is chosen.
OPTIONS: dict[str, dict[str, tuple[float, float] | str]] = {
    "flow law": {
        "valve.flow_law": "iso_6358",
        "valve.sonic_conductance": (1e-10, 1e-8),
        "valve.critical_ratio": (0.0, 0.9),
        "valve.subsonic_index": (0.3, 1.0),
    },
    "leak across": {"leak.across": (0.0, 1e-5)},
    "leaks to ambient": {"leak.a": (0.0, 1e-5), "leak.b": (0.0, 1e-5)},
    "tilt": {"rail.tilt": (-1.5707, 1.5707)},
    "exponent": {
        "chambers.thermodynamics": "polytropic",
        "chambers.polytropic_index": (1.0, 1.4),
    },
    "discharge": {"valve.discharge": "constant", "valve.discharge_coefficient": (0.2, 2.0)},
    "heat": {
        "chambers.thermodynamics": "energy_balance",
        "chambers.heat_transfer_coefficient": (0.0, 500.0),
        "chambers.wall_temperature": (250.0, 350.0),
    },
    "tubes": {
        "tubes.model": "delay",
        "tubes.length": (0.1, 5.0),
        "tubes.diameter": (2e-3, 4e-3),
        "cylinder.dead_volume_a": (6.3e-5, 1e-4),
        "cylinder.dead_volume_b": (6.3e-5, 1e-4),
    },
    "ripple": {
        "supply.ripple_amplitude": (1.0, 1e5),
        "supply.ripple_frequency": (0.1, 100.0),
    },
    "droop": {"supply.droop": (1e5, 1e8), "supply.time_constant": (1e-3, 1.0)},
    "compressor": {
        "supply.kind": "compressor",
        "supply.receiver_volume": (5e-4, 0.1),
        "supply.switch_on_pressure": (3.5e5, 4e5),
        "supply.switch_off_pressure": (8e5, 1e6),
        "supply.delivery": (1e-3, 1e-2),
    },
    "lugre": {
        "friction.dynamics": "lugre",
        "friction.bristle_stiffness": (2e4, 2e6),
        "friction.bristle_damping": (0.0, 3e3),
    },
    "coupling": {
        "coupling.kind": "magnetic",
        "coupling.holding_force": (300.0, 3e3),
        "coupling.damping": (0.0, 300.0),
        "coupling.piston_mass": (0.2, 0.8),
        "coupling.piston_friction": (0.0, 1.0),
    },
    "drift": {"friction.drift": (0.001, 0.3)},
}
# Compiling each of them together with all others takes minutes: they are drawn by pairs only.
BY_PAIRS = {"tubes", "ripple"}
# Both choose the same parameter: the last one wins.
CHOICES = ("exponent", "heat")
PAIRS = [pair for pair in combinations(OPTIONS, 2) if pair != CHOICES]
RANDOM = draws(2000, 300)


def drawn(generator: np.random.Generator, names: tuple[str, ...]) -> RigParameters:
    """A rig near a bare one with the options ``names``, their values drawn from their ranges.

    Small areas as often as large ones: half of what starts at zero is spread over four decades.
    """
    rig = bare_rig(str(generator.choice(BARE_RIGS)))
    values: dict[str, object] = {
        "supply.pressure": float(generator.uniform(4e5, 8e5)),
        "cylinder.moving_mass": float(generator.uniform(0.5, 4.0)),
        "valve.assembly": str(generator.choice(["reconciled", "printed"])),
    }
    for name in names:
        for parameter, found in OPTIONS[name].items():
            if isinstance(found, str):
                values[parameter] = found
                continue
            share = float(generator.random())
            if found[0] == 0.0 and generator.random() < 0.5:
                share = 10.0 ** -float(generator.uniform(0.0, 4.0))
            values[parameter] = found[0] + share * (found[1] - found[0])
    return rig.with_values(values)


def run_is_clean(parameters: RigParameters, generator: np.random.Generator) -> float:
    """Control the rig for two seconds; assert that it stays one, and return its travel (m)."""
    start, target = generator.uniform(0.0, 0.2, 2).tolist()
    law = bare_pid("saturating")
    step = references.step(start, target, at=0.05)
    run = closed_loop(parameters, law, step, 2.0, 1e-3, start)
    for name, values in run.columns().items():
        assert np.isfinite(values).all(), name
    assert run.position.min() >= 0.0
    assert run.position.max() <= 0.2
    ambient, supply = (parameters.number(f"{p}.pressure") for p in ("atmosphere", "supply"))
    # A carriage that is thrown compresses the air ahead of it, and expands that behind it.
    assert min(run.pressure_a.min(), run.pressure_b.min()) > 0.3 * ambient
    assert max(run.pressure_a.max(), run.pressure_b.max()) < 3.0 * supply
    return float(np.ptp(run.position))


@pytest.mark.parametrize("names", some_of(PAIRS, 8), ids=" and ".join)
def test_each_pair_runs(names: tuple[str, ...]) -> None:
    """Five rigs with both options, two seconds of closed loop each."""
    generator = np.random.default_rng([12, PAIRS.index(names)])
    for _ in range(5):
        run_is_clean(drawn(generator, names), generator)


def test_random_combinations_run() -> None:
    """Each option on in half of the rigs, two seconds each; most of them move."""
    generator = np.random.default_rng(2000)
    travels = []
    for _ in range(RANDOM):
        names = tuple(n for n in OPTIONS if n not in BY_PAIRS and generator.random() < 0.5)
        travels.append(run_is_clean(drawn(generator, names), generator))
    assert np.mean(np.array(travels) > 1e-3) > 0.7
