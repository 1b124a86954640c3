# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The chambers' heat: their air exchanges it with the wall, and brings and takes energy with it.

The paper prints one pressure equation, eq. (26), with the supply's temperature for all air. Its
place is taken by the balances of energy and mass of an ideal gas of one temperature T per chamber,

    d(m c_v T)/dt = Ḣ − P dV/dt + h A_w (T_w − T)          dm/dt = ṁ          P V = m R T

where the enthalpy Ḣ that flows in has the temperature of the air upstream. Solved for the two
states,

    V dP/dt = (κ − 1) (Ḣ + Q) − κ P dV/dt                  Q = h A_w (T_w − T)
    dT/dt = T/(P V) · ((κ − 1) (Ḣ + Q − P dV/dt) − R T ṁ)

T is the state, and not the mass m: one error in K fits every rig, while one in kg would have to
follow bore and dead volume; and a change of the dead volume while the rig runs leaves the air's
pressure and temperature as they are.
"""

from typing import NamedTuple

from rodless_base.kernels import kernel
from rodless_base.parameters import Parameter, ParameterSet, declare
from rodless_sim.physics.air import Air
from rodless_sim.physics.cylinder import piston_area
from rodless_sim.physics.sources import JUDGEMENT

ENERGY_BALANCE = "energy_balance"

PARAMETERS = declare(
    Parameter(
        "chambers.heat_transfer_coefficient",
        50.0,
        "W/(m²·K)",
        f"heat transfer coefficient h of the wall ({ENERGY_BALANCE}); 0 for adiabatic chambers",
        "Carneiro and Almeida 2006: order of magnitude",
        0.0,
        1e5,
    ),
    Parameter(
        "chambers.wall_temperature",
        293.15,
        "K",
        f"temperature T_w of the wall ({ENERGY_BALANCE})",
        f"{JUDGEMENT}: that of the room",
        200.0,
        400.0,
    ),
)


class Heat(NamedTuple):
    """Constants of chambers with temperatures of their own."""

    coefficient: float  # W/(m²·K)
    wall_temperature: float  # K
    ambient_temperature: float  # K, of what flows back from the atmosphere
    faces: float  # m², wall of a chamber without volume: piston and cap
    wall_by_volume: float  # 1/m


class NetInflow(NamedTuple):
    """The net mass flow into a chamber and the enthalpy it brings, by the states of both chambers.

    Those of the other matter where air leaks past the piston.
    """

    mass_flow: float  # kg/s
    by_pressure: float  # kg/(s·Pa)
    by_temperature: float  # kg/(s·K)
    by_other_pressure: float  # kg/(s·Pa)
    by_other_temperature: float  # kg/(s·K)
    enthalpy_flow: float  # W
    enthalpy_by_pressure: float  # W/Pa
    enthalpy_by_temperature: float  # W/K
    enthalpy_by_other_pressure: float  # W/Pa
    enthalpy_by_other_temperature: float  # W/K


class Row(NamedTuple):
    """A rate of change, and all that it changes with; ``unit`` is that of what changes."""

    rate: float  # unit/s
    by_position: float  # unit/(s·m)
    by_velocity: float  # unit/m
    by_pressure: float  # unit/(s·Pa)
    by_temperature: float  # unit/(s·K)
    by_other_pressure: float  # unit/(s·Pa), with the other chamber's
    by_other_temperature: float  # unit/(s·K), likewise


class HeatedRate(NamedTuple):
    """The rates of change of a chamber's two states."""

    pressure: Row
    temperature: Row


def of(parameters: ParameterSet) -> Heat | tuple[()]:
    """Return the constants for ``parameters``; none where the chambers have no temperature."""
    if parameters.text("chambers.thermodynamics") != ENERGY_BALANCE:
        return ()
    return balance(parameters)


def balance(parameters: ParameterSet, in_use: bool = True) -> Heat:
    """Return the constants of the balance for ``parameters``.

    Where it is not ``in_use`` all air has the supply's temperature, that of the atmosphere too.

    The dead volume is a cavity of the cylinder, a tube and fittings in unknown proportions. Its
    wall is taken for that of as much more bore: the wall grows by 4/d with any volume. A bare tube
    of 4 mm would have six times as much, and the chamber would fill 4 % later.
    """
    return Heat(
        coefficient=parameters.number("chambers.heat_transfer_coefficient"),
        wall_temperature=parameters.number("chambers.wall_temperature"),
        ambient_temperature=parameters.number(
            f"{'atmosphere' if in_use else 'supply'}.temperature"
        ),
        faces=2.0 * piston_area(parameters),
        wall_by_volume=4.0 / parameters.number("cylinder.bore"),
    )


@kernel
def enthalpy_capacity(air: Air) -> float:
    """Specific heat at constant pressure c_p in J/(kg·K)."""
    index = air.isentropic_index
    return index / (index - 1.0) * air.gas_constant


@kernel
def wall_area(heat: Heat, volume: float) -> float:
    """Area in m² through which the air of a chamber of ``volume`` (m³) exchanges heat."""
    return heat.faces + heat.wall_by_volume * volume


@kernel
def heated_rate(
    air: Air,
    heat: Heat,
    volume: float,
    area: float,
    velocity: float,
    pressure: float,
    temperature: float,
    inflow: NetInflow,
) -> HeatedRate:
    """Return dP/dt and dT/dt of a chamber, from its energy and its mass.

    ``area`` (m²) is that by which the volume grows with the position: negative for chamber B.
    """
    index, constant = air.isentropic_index, air.gas_constant
    less = index - 1.0
    growth = area * velocity
    loss = heat.coefficient * wall_area(heat, volume)
    colder = heat.wall_temperature - temperature
    power = inflow.enthalpy_flow + loss * colder
    power_by_position = heat.coefficient * heat.wall_by_volume * area * colder
    power_by_temperature = inflow.enthalpy_by_temperature - loss

    pressure_rate = (less * power - index * pressure * growth) / volume
    of_pressure = Row(
        pressure_rate,
        (less * power_by_position - area * pressure_rate) / volume,
        -index * pressure * area / volume,
        (less * inflow.enthalpy_by_pressure - index * growth) / volume,
        less * power_by_temperature / volume,
        less * inflow.enthalpy_by_other_pressure / volume,
        less * inflow.enthalpy_by_other_temperature / volume,
    )
    share = temperature / (pressure * volume)
    exchange = constant * inflow.mass_flow
    temperature_rate = share * (less * (power - pressure * growth) - exchange * temperature)
    of_temperature = Row(
        temperature_rate,
        share * less * power_by_position - area / volume * temperature_rate,
        -share * less * pressure * area,
        share
        * (
            less * (inflow.enthalpy_by_pressure - growth)
            - constant * temperature * inflow.by_pressure
        )
        - temperature_rate / pressure,
        share
        * (less * power_by_temperature - exchange - constant * temperature * inflow.by_temperature)
        + temperature_rate / temperature,
        share
        * (
            less * inflow.enthalpy_by_other_pressure
            - constant * temperature * inflow.by_other_pressure
        ),
        share
        * (
            less * inflow.enthalpy_by_other_temperature
            - constant * temperature * inflow.by_other_temperature
        ),
    )
    return HeatedRate(of_pressure, of_temperature)
