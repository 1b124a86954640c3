# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Every derivative beside an equation against a numerical one, at random states."""

import math
from collections.abc import Callable
from functools import partial

import numpy as np
import pytest

from rodless_sim import RigParameters
from rodless_sim.physics.cylinder import chamber_rate, pressure_rate
from rodless_sim.physics.equations import applied, inflows, rates, sliding_rates
from rodless_sim.physics.flow import gap, nozzle, orifice
from rodless_sim.physics.friction import sliding
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import flow_past, inflow_a, inflow_b, openings
from rodless_sim.physics.state import Motion
from rodless_sim.physics.valve_assemblies.printed import gap_printed

PLANT = Plant.of(RigParameters())
AIR = PLANT.air
GENERATOR = np.random.default_rng(9)
PRESSURES = GENERATOR.uniform(1e5, 7e5, (60, 2)).tolist()


def slope(function: Callable[[float], float], place: float, width: float) -> float:
    """Central difference of fourth order."""
    near = function(place + width) - function(place - width)
    far = function(place + 2.0 * width) - function(place - 2.0 * width)
    return (8.0 * near - far) / (12.0 * width)


def near(value: float, scale: float) -> object:
    """What a difference of fourth order can tell of a derivative of about ``scale``."""
    return pytest.approx(value, rel=1e-6, abs=1e-7 * abs(scale))


@pytest.mark.parametrize(
    "ratio", [0.1, 0.5, 0.527, 0.53, 0.6, 0.8, 0.95, 0.99, 0.998, 0.9992, 0.9995, 0.9999]
)
def test_the_nozzle(ratio: float) -> None:
    """Choked, on both sides of b, nearly equal pressures, and the straight part beyond 0.999."""
    _, by_ratio = nozzle(AIR, ratio)
    expected = slope(lambda r: nozzle(AIR, r)[0], ratio, 5e-5 if ratio > 0.9 else 1e-4)
    assert by_ratio == pytest.approx(expected, rel=1e-4, abs=1e-9)


def test_the_nozzle_by_complex_step() -> None:
    """Eq. (6) with a complex ratio: exact to rounding between b and 0.999."""
    for ratio in GENERATOR.uniform(0.53, 0.999, 100):
        r = complex(ratio, 1e-30)
        q = r ** (1.0 / 1.4)
        exact = (2.8 / 0.4 * (q * q - r * q)) ** 0.5
        assert nozzle(AIR, ratio) == pytest.approx((exact.real, exact.imag / 1e-30), rel=1e-11)


@pytest.mark.parametrize("flow", ["orifice", "gap", "gap_printed"])
def test_flows_by_both_pressures(flow: str) -> None:
    """Random pressures, either side the higher, and a hair on each side of equal ones."""

    def passed(one: float, two: float) -> tuple[float, float, float]:
        if flow == "orifice":
            return orifice(AIR, 1e-6, one, two)
        return gap(5e-17, one, two) if flow == "gap" else gap_printed(5e-17, one, two)

    equal = [(4e5, 4e5 * (1.0 + hair)) for hair in (5e-4, -5e-4, 5e-3, -5e-3)]
    for one, two in [*PRESSURES, *equal]:
        found = passed(one, two)
        by_one = slope(lambda p, two=two: passed(p, two)[0], one, 20.0)
        by_two = slope(lambda p, one=one: passed(one, p)[0], two, 20.0)
        scale = max(abs(by_one), abs(by_two))
        assert found[1] == near(by_one, scale)
        assert found[2] == near(by_two, scale)


def test_an_orifice_with_its_sides_exchanged_exchanges_its_derivatives() -> None:
    """ṁ(p, q) = -ṁ(q, p), therefore ∂₁ṁ(p, q) = -∂₂ṁ(q, p)."""
    for one, two in PRESSURES:
        found, other = orifice(AIR, 1e-6, one, two), orifice(AIR, 1e-6, two, one)
        assert found == (-other[0], -other[2], -other[1])


@pytest.mark.parametrize("assembly", ["reconciled", "printed"])
def test_edges_and_chambers_by_pressure(assembly: str) -> None:
    """At closed, half and wide open, both ways."""
    plant = Plant.of(RigParameters({"valve.assembly": assembly}))
    for voltage in (0.0, 4.6, 5.08, 5.3, 9.0):
        lands = openings(plant, voltage)
        opening = partial(flow_past, plant, lands.opening)
        for one, two in PRESSURES[:20]:
            by_two = slope(lambda p, one=one, past=opening: past(one, p)[0], two, 20.0)
            assert opening(one, two)[2] == near(by_two, opening(one, two)[1])
            for inflow in (partial(inflow_a, plant, lands), partial(inflow_b, plant, lands)):
                expected = slope(lambda p, inflow=inflow: inflow(p)[0], one, 20.0)
                assert inflow(one)[1] == near(expected, 1e-10)


@pytest.mark.parametrize("form", ["stribeck", "saturating"])
@pytest.mark.parametrize("direction", [1, -1])
def test_friction_by_velocity(form: str, direction: int) -> None:
    """Over four decades of speed; below zero it goes on in a straight line."""
    friction = Plant.of(RigParameters({"friction.form": form})).friction
    for speed in 10.0 ** GENERATOR.uniform(-4.0, 0.0, 60):
        velocity = direction * float(speed)
        expected = slope(lambda v: sliding(friction, v, direction).force, velocity, 1e-3 * speed)
        assert sliding(friction, velocity, direction).by_speed == near(expected, expected)
    at_rest = sliding(friction, 0.0, direction)
    backwards = sliding(friction, -direction * 0.01, direction)
    assert backwards.by_speed == at_rest.by_speed
    assert direction * backwards.force == pytest.approx(
        direction * at_rest.force - 0.01 * at_rest.by_speed, rel=1e-12
    )


def test_chamber_pressure_rates() -> None:
    """Eq. (26) by position, velocity and pressure, for a chamber that grows and one that shrinks.

    The flow in is given a slope of its own.
    """
    for area in (4.9e-4, -4.9e-4):
        for _ in range(30):
            y, v = GENERATOR.uniform(0.0, 0.2), GENERATOR.uniform(-1.0, 1.0)
            p, flow = GENERATOR.uniform(1e5, 7e5), GENERATOR.uniform(-1e-3, 1e-3)

            def rate(y: float, v: float, p: float, area: float = area, at: float = p) -> float:
                volume = 1.2e-4 + area * y
                return pressure_rate(AIR, volume, area * v, p, flow - 3e-9 * (p - at))  # noqa: B023

            found = chamber_rate(AIR, 1.2e-4 + area * y, area, v, p, flow, -3e-9, 0.0)
            assert found.rate == rate(y, v, p)
            assert found.by_position == near(slope(lambda x: rate(x, v, p), y, 1e-4), found[1])  # noqa: B023
            assert found.by_velocity == near(slope(lambda x: rate(y, x, p), v, 1e-3), found[2])  # noqa: B023
            assert found.by_pressure == near(slope(lambda x: rate(y, v, x), p, 20.0), found[3])  # noqa: B023


@pytest.mark.parametrize("form", ["stribeck", "saturating"])
@pytest.mark.parametrize("assembly", ["reconciled", "printed"])
def test_the_whole_matrix(form: str, assembly: str) -> None:
    """All derivatives of a sliding rig, those that are taken for zero included."""
    plant = Plant.of(RigParameters({"friction.form": form, "valve.assembly": assembly}))
    widths = (1e-5, 1e-6, 20.0, 20.0)
    for voltage in (3.0, 5.2, 7.0):
        lands = openings(plant, voltage)
        for _ in range(20):
            direction = int(GENERATOR.choice((-1, 1)))
            speed = float(10.0 ** GENERATOR.uniform(-3.5, 0.0))
            state = Motion(
                GENERATOR.uniform(0.01, 0.19),
                direction * speed,
                *GENERATOR.uniform(1.1e5, 5.5e5, 2).tolist(),
            )
            found = sliding_rates(plant, state, inflows(plant, lands, state), direction)
            assert tuple(rates(plant, lands, state, direction)) == (
                found.velocity,
                found.acceleration,
                found.a.rate,
                found.b.rate,
            )
            a, b, push = found.a, found.b, found.by_pressure
            matrix = np.array(
                [
                    [0.0, 1.0, 0.0, 0.0],
                    [found.by_position, found.by_velocity, push, -push],
                    [a.by_position, a.by_velocity, a.by_pressure, 0.0],
                    [b.by_position, b.by_velocity, 0.0, b.by_pressure],
                ]
            )
            expected = np.empty((4, 4))
            for column, width in enumerate(widths):
                for row in range(4):

                    def value(x: float, row: int = row, column: int = column) -> float:
                        changed = [*state]  # noqa: B023
                        changed[column] = x
                        return rates(plant, lands, Motion(*changed), direction)[row]  # noqa: B023

                    expected[row, column] = slope(value, state[column], width)
            scale = np.abs(expected).max(axis=0) + 1e-9
            assert np.abs((matrix - expected) / scale).max() < 1e-5


def test_other_forces_are_none() -> None:
    """Without any in the list, the push is that of the air, and changes with nothing else."""
    force = applied(PLANT, Motion(0.1, 0.3, 4e5, 3e5))
    assert force == (pytest.approx(math.pi / 4.0 * 0.025**2 * 1e5), 0.0, 0.0)
