# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The constants of all equations, each physical thing's own together."""

from typing import Any, NamedTuple

from rodless_base.kernels import kernel
from rodless_base.parameters import ParameterSet
from rodless_sim.faults import damaged
from rodless_sim.physics import forces, full, heat, spool, supply, tubes
from rodless_sim.physics.air import Air
from rodless_sim.physics.cylinder import Cylinder
from rodless_sim.physics.end_stop import EndStop
from rodless_sim.physics.flow_law import FlowLaw
from rodless_sim.physics.friction import Friction
from rodless_sim.physics.leak import Leak
from rodless_sim.physics.valve import Valve
from rodless_sim.physics.valve_assembly import Assembly


class Plant(NamedTuple):
    """Everything that stays constant while the rig moves."""

    air: Air
    valve: Valve
    assembly: Assembly
    flow_law: FlowLaw
    cylinder: Cylinder
    leak: Leak
    friction: Friction
    end_stop: EndStop
    forces: tuple[Any, ...]  # constants of each of forces.FORCES
    supply_pressure: float  # Pa, absolute
    ambient_pressure: float  # Pa, absolute
    heat: Any  # Heat, () where the equations have no temperatures of the chambers
    drive: Any  # Drive, () where the spool follows the command at once
    full: Any  # Full, () where no option needs the states of FullMotion
    ripple: Any  # Ripple, () where the supply is steady
    tubes: Any  # Tube, () where air from the valve arrives at once

    @classmethod
    def of(cls, parameters: ParameterSet) -> "Plant":
        """Return the constants for ``parameters``, those of a rig."""
        air, valve = Air.of(parameters), Valve.of(parameters)
        further, tube = full.of(parameters), tubes.of(parameters)
        plant = cls(
            air=air,
            valve=valve,
            assembly=Assembly.of(parameters, air, valve),
            flow_law=FlowLaw.of(parameters),
            cylinder=Cylinder.of(parameters),
            leak=Leak.of(parameters),
            friction=Friction.of(parameters),
            end_stop=EndStop.of(parameters),
            forces=forces.of(parameters),
            supply_pressure=parameters.number("supply.pressure"),
            ambient_pressure=parameters.number("atmosphere.pressure"),
            heat=heat.balance(parameters, further.heated) if further else heat.of(parameters),
            drive=spool.of(parameters),
            full=further,
            # One of nothing, if need be: each kind of plant takes a minute to compile.
            ripple=supply.of(parameters, kept=bool(further or tube)),
            tubes=tube,
        )
        return damaged(plant, parameters)

    @property
    def heated(self) -> bool:
        """Whether the chambers have temperatures of their own."""
        return bool(self.full.heated if self.full else self.heat)


@kernel
def supplied(plant: Plant, pressure: float) -> Plant:
    """Return the same plant with the supply at ``pressure`` (Pa)."""
    return Plant(
        air=plant.air,
        valve=plant.valve,
        assembly=plant.assembly,
        flow_law=plant.flow_law,
        cylinder=plant.cylinder,
        leak=plant.leak,
        friction=plant.friction,
        end_stop=plant.end_stop,
        forces=plant.forces,
        supply_pressure=pressure,
        ambient_pressure=plant.ambient_pressure,
        heat=plant.heat,
        drive=plant.drive,
        full=plant.full,
        ripple=plant.ripple,
        tubes=plant.tubes,
    )
