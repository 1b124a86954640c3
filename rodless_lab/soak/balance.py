# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Whether what flows into the chambers is found in them: the balance of a run, from its samples.

Of eq. (26), integrated: the enthalpy that flows in, κ/(κ−1) R T ṁ, is the internal energy P V/(κ−1)
that the air gains and the work P dV that it does. Flows come from the valve's equations at each
end of a period, so the run's own integration has no part in them.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from rodless_base.kernels import outlined_kernel
from rodless_sim import RigParameters, Trace
from rodless_sim.physics.cylinder import volume_a, volume_b
from rodless_sim.physics.equations import inflows
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings
from rodless_sim.physics.state import Motion

Array = npt.NDArray[np.float64]


class Balance(NamedTuple):
    """Of both chambers together, over a run."""

    inflow: float  # J, enthalpy that came in, less what left
    gained: float  # J, of internal energy
    work: float  # J, done by the air
    turnover: float  # J, enthalpy in and out, both counted positive

    @property
    def gap(self) -> float:
        """What does not close, as a share of the turnover."""
        return abs(self.inflow - self.gained - self.work) / self.turnover


def balance(parameters: RigParameters, run: Trace, period: float) -> Balance:
    """Return the balance of ``run``, whose samples are ``period`` s apart."""
    plant = Plant.of(parameters)
    return Balance(*_sums(plant, run.position, run.pressure_a, run.pressure_b, run.voltage, period))


@outlined_kernel
def _sums(
    plant: Plant, position: Array, pressure_a: Array, pressure_b: Array, voltage: Array, step: float
) -> tuple[float, float, float, float]:
    """Inflow, gain, work and turnover in J, by the trapezoidal rule."""
    air, cylinder = plant.air, plant.cylinder
    enthalpy = air.isentropic_index / (air.isentropic_index - 1.0)
    enthalpy *= air.gas_constant * air.temperature * 0.5 * step
    inflow = turnover = work = 0.0
    for k in range(position.size - 1):
        lands = openings(plant, voltage[k])
        for a, b in ((pressure_a[k], pressure_b[k]), (pressure_a[k + 1], pressure_b[k + 1])):
            into = inflows(plant, lands, Motion(position[k], 0.0, a, b))
            inflow += enthalpy * (into.a.mass_flow + into.b.mass_flow)
            turnover += enthalpy * (abs(into.a.mass_flow) + abs(into.b.mass_flow))
        force = pressure_a[k] - pressure_b[k] + pressure_a[k + 1] - pressure_b[k + 1]
        work += 0.5 * force * cylinder.piston_area * (position[k + 1] - position[k])
    held = np.zeros(2)
    for j in range(2):
        k = -j
        held[j] = pressure_a[k] * volume_a(cylinder, position[k])
        held[j] += pressure_b[k] * volume_b(cylinder, position[k])
    gained = (held[1] - held[0]) / (air.isentropic_index - 1.0)
    return inflow, gained, work, turnover
