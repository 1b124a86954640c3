# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The stand of Figs. 6 and 10: one port of the valve blows to atmosphere through a flow meter."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rodless_lab.experiments.result import Comparison, Limits
from rodless_lab.identification.estimate import Estimate
from rodless_sim import RigParameters
from rodless_sim.instruments.instruments import PRESSURE_RANGE, Instruments
from rodless_sim.physics.flow import orifice_flow
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import edge_flow, openings
from rodless_sim.physics.valve import effective_area

Array = npt.NDArray[np.float64]

# Density of free air in kg/m³ (ISO 8778: 0.1 MPa, 20 °C, 65 % humidity), to which flow meters and
# eq. (4) refer.
FREE_AIR_DENSITY = 1.185

# Every voltage is held this long (s) before it is read: far longer than any lag.
READING_TIME = 1.0


# Bounds of what the instruments of a stand misread, all of it alike: the flow meter's gain, and the
# pressure transmitter's bias relative to the supply.
def systematic_share(parameters: RigParameters) -> float:
    """Largest share by which an area or C_v from this stand is wrong throughout."""
    bias = parameters.number("sensors.pressure_bias") * PRESSURE_RANGE
    gain = parameters.number("sensors.flow_gain_error")
    return gain + bias / parameters.number("supply.pressure")


def bare_flow(plant: Plant, voltages: Array) -> Array:
    """Mass flow in kg/s to atmosphere through the area of eq. (5) alone, shape (n,).

    Eq. (4) knows no flow coefficient: the area that section 3.2 measures contains it.
    """
    return np.array(
        [
            orifice_flow(
                plant.air,
                effective_area(plant.valve, float(voltage)),
                plant.supply_pressure,
                plant.ambient_pressure,
            )
            for voltage in voltages
        ]
    )


def port_flow(plant: Plant, voltages: Array, downstream: float | None = None) -> Array:
    """Mass flow in kg/s out of the opening port, shape (n,): Port 4 above closed, Port 2 below.

    ``downstream`` (Pa) is ambient unless given.
    """
    pressure = plant.ambient_pressure if downstream is None else downstream
    flows = []
    for voltage in voltages:
        opening = openings(plant, float(voltage)).opening
        flows.append(edge_flow(plant, opening, plant.supply_pressure, pressure))
    return np.array(flows)


def interval_row(
    estimates: Sequence[Estimate], truth: Array, systematic: Sequence[float]
) -> Comparison:
    """Compare fitted coefficients with ``truth`` by their 95 % intervals.

    ``systematic`` is the share of itself by which each may be wrong throughout.
    """
    distances = [
        abs(found.value - true) / found.widened(share * abs(found.value)).half_width
        for found, true, share in zip(estimates, truth, systematic, strict=True)
    ]
    return Comparison(
        "with noise: farthest coefficient from the paper's, in half widths of its 95 % interval",
        max(distances),
        "",
        "no intervals",
        Limits(
            0.0,
            2.0,
            "the farthest of several: each leaves twice its interval in one case of ten thousand",
        ),
    )


@dataclass(frozen=True)
class Stand:
    """The instruments of one stand, with the fixed errors of these specimens, and their noise."""

    instruments: Instruments
    generator: np.random.Generator

    @classmethod
    def specimen(cls, parameters: RigParameters, seed: int) -> "Stand":
        """Choose the instruments that the ``sensors.*`` of ``parameters`` describe."""
        generator = np.random.default_rng(seed)
        return cls(Instruments.specimen(parameters, generator), generator)

    def flow(self, mass_flow: Array) -> Array:
        """Return what the meter reads of ``mass_flow`` (kg/s), in m³/s of free air."""
        return self.instruments.volume_flow.measure(
            mass_flow / FREE_AIR_DENSITY, READING_TIME, self.generator
        )

    def supply(self, pressure: float, count: int) -> Array:
        """Return ``count`` readings in Pa absolute of a constant ``pressure``."""
        return self.instruments.supply_pressure.measure(
            np.full(count, pressure), READING_TIME, self.generator
        )
