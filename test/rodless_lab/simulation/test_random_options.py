# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Random combinations of all that the paper leaves out run clean in closed loop."""

import math

import numpy as np
from extent import extensive

from rodless_control import references
from rodless_lab import closed_loop
from rodless_lab.bare_rigs import BARE_RIGS, bare_pid, bare_rig

COUNT = 120


def options(draw: np.random.Generator) -> dict[str, dict[str, object]]:
    """Each option with parameters of its own, from mild to beyond what is sold."""

    def between(low: float, high: float) -> float:
        """As often in each decade."""
        return float(low * (high / low) ** draw.random())

    return {
        "flow law": {
            "valve.flow_law": "iso_6358",
            "valve.sonic_conductance": between(1e-9, 1e-8),
            "valve.critical_ratio": float(draw.uniform(0.1, 0.6)),
        },
        "discharge": {
            "valve.discharge": "constant",
            "valve.discharge_coefficient": float(draw.uniform(0.5, 1.5)),
        },
        "printed": {"valve.assembly": "printed"},
        "leaks": {f"leak.{where}": between(1e-9, 1e-6) for where in ("across", "a", "b")},
        "tilt": {"rail.tilt": float(draw.uniform(-math.pi / 2.0, math.pi / 2.0))},
        "heat": {
            "chambers.thermodynamics": "energy_balance",
            "chambers.heat_transfer_coefficient": between(1.0, 1e4),
        },
        "spool": {
            "valve.dynamics": "second_order",
            "valve.natural_frequency": between(2.0, 2000.0),
            "valve.damping": between(0.05, 5.0),
        },
        "hysteresis": {"valve.hysteresis": between(1e-4, 0.1)},
        "dead time": {"valve.dead_time": between(1e-9, 0.05)},
        "friction": {"friction.form": "saturating"},
        "lugre": {
            "friction.dynamics": "lugre",
            "friction.bristle_stiffness": between(2e4, 2e6),
            "friction.bristle_damping": between(1.0, 3e3),
        },
        "coupling": {
            "coupling.kind": "magnetic",
            "coupling.holding_force": between(300.0, 3e3),
            "coupling.damping": between(1.0, 300.0),
            "coupling.piston_friction": float(draw.random()),
        },
        "drift": {"friction.drift": between(1e-3, 0.3)},
    }


@extensive
def test_random_combinations_run_clean() -> None:
    """Two seconds of a step each: finite, within the stroke, pressures that a rig can have."""
    chosen_at_all: dict[str, int] = {}
    moved = 0
    for number in range(COUNT):
        draw = np.random.default_rng([12, number])
        chosen = {name: each for name, each in options(draw).items() if draw.random() < 0.5}
        values = {name: value for each in chosen.values() for name, value in each.items()}
        name = str(draw.choice(BARE_RIGS[::-1]))
        rig = bare_rig(name).with_values(values)
        start, goal = draw.uniform(0.0, 0.2, 2).tolist()
        step = references.step(start, goal, at=0.1)
        run = closed_loop(rig, bare_pid(name), step, 2.0, 1e-3, position=start)
        columns = run.columns()
        assert all(np.isfinite(column).all() for column in columns.values()), values
        assert 0.0 <= run.position.min() <= run.position.max() <= 0.2, values
        for pressure in (run.pressure_a, run.pressure_b):
            assert 5e4 < pressure.min() <= pressure.max() < 3e6, values
        assert ("spool_voltage" in columns) == bool(
            {"spool", "hysteresis", "dead time"} & {*chosen}
        )
        if "spool_voltage" in columns:
            assert 0.0 <= run.spool_voltage.min() <= run.spool_voltage.max() <= 10.0
        for name in chosen:
            chosen_at_all[name] = chosen_at_all.get(name, 0) + 1
        moved += bool(np.ptp(run.position) > 1e-3)
    assert len(chosen_at_all) == 13
    assert min(chosen_at_all.values()) > 30
    assert moved > COUNT // 2
