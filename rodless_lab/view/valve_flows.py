# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What flows past the valve's four edges, from readings and the plant's own parameters."""

from collections.abc import Mapping
from typing import NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from rodless_base.constants import MAXIMUM_VOLTAGE, MINIMUM_VOLTAGE
from rodless_sim import RigParameters
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import edge_flow, openings
from rodless_sim.physics.valve import SPOOL_GAIN, SPOOL_OFFSET

Number = TypeVar("Number", float, npt.NDArray[np.float64])

# From m³/s to L/min.
LITRES_PER_MINUTE = 6e4


def spool_voltage(displacement: Number) -> Number:
    """Return the voltage (V) that holds the spool at a displacement (m), by eq. (24)."""
    return (displacement - SPOOL_OFFSET) / SPOOL_GAIN


class EdgeFlows(NamedTuple):
    """Free-air flows in L/min past the edges; negative against the direction in the name."""

    supply_to_a: float
    a_to_exhaust: float
    supply_to_b: float
    b_to_exhaust: float


class ValveFlows:
    """The valve of one set of parameters, as :mod:`rodless_sim.physics.ports` has it.

    Air has the supply's temperature on its way, as in eq. (26).
    """

    def __init__(self, parameters: Mapping[str, object]) -> None:
        """Take a plant's parameters by name; raises ParameterError for those of no rig."""
        values = {name: parameters[name] for name in RigParameters.DECLARATIONS}
        own = RigParameters(values)
        self._plant = Plant.of(own)
        # m³/kg in the atmosphere around the rig, as Rig.free_air_flow has it.
        temperature = own.number("atmosphere.temperature")
        volume = self._plant.air.gas_constant * temperature / self._plant.ambient_pressure
        self._to_litres = LITRES_PER_MINUTE * volume

    def at(
        self, voltage: float, pressure_a: float, pressure_b: float, supply_pressure: float
    ) -> EdgeFlows:
        """Return the flows with the spool where ``voltage`` (V) holds it; pressures absolute."""
        plant, ambient = self._plant, self._plant.ambient_pressure
        lands = openings(plant, min(max(voltage, MINIMUM_VOLTAGE), MAXIMUM_VOLTAGE))
        forward, reverse = lands.opening, lands.closing
        if not lands.forward:
            forward, reverse = reverse, forward
        mass_flows = (
            edge_flow(plant, forward, supply_pressure, pressure_a),
            edge_flow(plant, reverse, pressure_a, ambient),
            edge_flow(plant, reverse, supply_pressure, pressure_b),
            edge_flow(plant, forward, pressure_b, ambient),
        )
        return EdgeFlows(*(flow * self._to_litres for flow in mass_flows))
