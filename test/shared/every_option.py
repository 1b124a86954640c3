# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Short runs of rigs that have every option among them; as a program, saved to the file named."""

import sys

import numpy as np
import numpy.typing as npt

from rodless_lab.bare_rigs import bare_rig
from rodless_sim import simulate

PERIOD = 1e-3
VOLTAGES = np.repeat([10.0, 5.08, 0.0, 8.0, 5.0], [200, 30, 150, 100, 20])

HEAT = {"chambers.thermodynamics": "energy_balance"}
TUBES = {
    "tubes.model": "delay",
    "tubes.length": 0.5,
    "cylinder.dead_volume_a": 3e-5,
    "cylinder.dead_volume_b": 3e-5,
}
SPOOL = {"valve.dynamics": "second_order", "valve.hysteresis": 0.004}
BRISTLES = {"friction.dynamics": "lugre"}
# They part, and the piston may catch the carriage again: friction alone is more than they hold.
MAGNETS = {
    "coupling.kind": "magnetic",
    "coupling.holding_force": 25.0,
    "cylinder.moving_mass": 2.5,
}
COMPRESSOR = {
    "supply.kind": "compressor",
    "supply.receiver_volume": 5e-4,
    "supply.switch_on_pressure": 6.0e5,
    "supply.switch_off_pressure": 6.25e5,
    "supply.delivery": 5e-3,
}

RIGS: dict[str, dict[str, object]] = {
    "tubes": TUBES,
    "tubes, heat, spool, late": {**TUBES, **HEAT, **SPOOL, "valve.dead_time": 3e-3},
    "tubes, magnets": {**TUBES, **MAGNETS},
    "ripple, late": {
        "supply.ripple_amplitude": 2e4,
        "supply.ripple_frequency": 50.0,
        "valve.dead_time": 2.5e-3,
    },
    "ripple, heat": {"supply.ripple_amplitude": 2e4, "supply.ripple_frequency": 50.0, **HEAT},
    "droop, ISO 6358, leaks": {
        "supply.droop": 2e7,
        "supply.time_constant": 0.02,
        "valve.flow_law": "iso_6358",
        "leak.across": 1e-8,
        "leak.a": 1e-8,
        "leak.b": 1e-8,
    },
    "bristles": BRISTLES,
    "bristles, heat, spool, compressor": {**BRISTLES, **HEAT, **SPOOL, **COMPRESSOR},
    "magnets, drift": {**MAGNETS, "friction.drift": 0.2},
    "magnets, bristles, heat, tilt": {**MAGNETS, **BRISTLES, **HEAT, "rail.tilt": 0.5},
    "compressor, drift": {**COMPRESSOR, "friction.drift": 0.2},
}


def run_of(name: str) -> npt.NDArray[np.float64]:
    """Half a second of a rig that begins 30 mm short of the end: the columns, shape (columns, n).

    The first are time, position and velocity; see ``rodless_sim.Trace``.
    """
    rig = bare_rig("saturating").with_values(RIGS[name])
    run = simulate(rig, VOLTAGES, PERIOD, position=0.17)
    return np.array(list(run.columns().values()), dtype=np.float64)


if __name__ == "__main__":
    np.savez(sys.argv[1], **{name: run_of(name) for name in RIGS})
