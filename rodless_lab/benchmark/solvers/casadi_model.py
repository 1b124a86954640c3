# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The rig's equations once more, as CasADi's symbols: it derives what it integrates."""

import math
from typing import Any

import casadi

from rodless_sim.physics.flow import LAMINAR_RATIO
from rodless_sim.physics.friction import FORMS
from rodless_sim.physics.friction_forms import saturating
from rodless_sim.physics.friction_forms.direction import Direction
from rodless_sim.physics.plant import Plant

# Its types are of no use here.
ca: Any = casadi
Symbol = Any


def orifice(plant: Plant, area: Symbol, pressure_1: Symbol, pressure_2: Symbol) -> Symbol:
    """Mass flow in kg/s, eqs. (6), (7)."""
    air = plant.air
    index = air.isentropic_index
    upstream = ca.fmax(pressure_1, pressure_2)
    ratio = ca.fmin(pressure_1, pressure_2) / upstream
    bounded = ca.fmin(ratio, LAMINAR_RATIO)
    density = bounded ** (1.0 / index)
    nozzle = ca.sqrt(2.0 * index / (index - 1.0) * (density * density - bounded * density))
    laminar = nozzle * (1.0 - ratio) / (1.0 - LAMINAR_RATIO)
    flowing = ca.if_else(ratio > LAMINAR_RATIO, laminar, nozzle)
    function = ca.if_else(ratio < air.critical_ratio, air.choked_function, flowing)
    conductance = area / math.sqrt(air.gas_constant * air.temperature)
    flow = conductance * upstream * function
    return ca.if_else(pressure_1 >= pressure_2, flow, -flow)


def inflow(plant: Plant, inlet: Symbol, outlet: Symbol, pressure: Symbol) -> Symbol:
    """Net mass flow into a chamber in kg/s; edges are pairs of area and gap, shape (2,)."""
    supply, ambient = plant.supply_pressure, plant.ambient_pressure
    inward = orifice(plant, inlet[0], supply, pressure)
    inward += inlet[1] * (supply**2 - pressure**2)
    outward = orifice(plant, outlet[0], pressure, ambient)
    return inward - outward - outlet[1] * (pressure**2 - ambient**2)


def friction(plant: Plant, side: Direction, speed: Symbol) -> Symbol:
    """Friction in N at ``speed`` (m/s) in the direction of ``side``; straight below zero."""
    ahead = ca.fmax(speed, 0.0)
    drop = (side.static - side.coulomb) * ca.exp(-((ahead / side.stribeck_velocity) ** 2))
    viscous, slope = side.viscous * speed, side.viscous
    if FORMS[plant.friction.form] is saturating:
        own = plant.friction.own[plant.friction.form]
        high, knee = own.high_speed_viscous, own.saturation_velocity
        bend = (slope - high) * (knee * (1.0 - ca.exp(-ahead / knee)))
        viscous = high * speed + bend + (slope - high) * ca.fmin(speed, 0.0)
    return side.coulomb + drop + viscous


def rates(plant: Plant, state: Symbol, held: Symbol) -> Symbol:
    """Rates of change of ``state``, shape (4,), with what is ``held``: right_hand_side.py."""
    cylinder, air = plant.cylinder, plant.air
    position, velocity, pressure_a, pressure_b = (state[k] for k in range(4))
    opening, closing = held[1:3], held[3:5]
    to_a = ca.if_else(held[0] > 0.0, opening, closing)
    to_b = ca.if_else(held[0] > 0.0, closing, opening)
    direction = held[5]
    slides = direction**2
    forward = friction(plant, plant.friction.forward, velocity)
    reverse = -friction(plant, plant.friction.reverse, -velocity)
    drag = ca.if_else(direction > 0.0, forward, reverse)
    area = cylinder.piston_area
    force = area * (pressure_a - pressure_b) - drag
    heat = air.gas_constant * air.temperature
    volume_a = cylinder.dead_volume_a + area * position
    volume_b = cylinder.dead_volume_b + area * (cylinder.stroke - position)
    swept = area * velocity * slides
    flow_a = heat * inflow(plant, to_a, to_b, pressure_a)
    flow_b = heat * inflow(plant, to_b, to_a, pressure_b)
    index = air.isentropic_index
    return ca.vertcat(
        velocity * slides,
        slides * force / cylinder.moving_mass,
        index / volume_a * (flow_a - pressure_a * swept),
        index / volume_b * (flow_b + pressure_b * swept),
    )
