# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The errata as numbers: what an equation does as printed, what the form used does."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from rodless_base.constants import CLOSED_VOLTAGE, STANDARD_ATMOSPHERE, absolute
from rodless_lab.experiments.errata_pictures import (
    PRINTED_OFFSET,
    assembled,
    held_force,
    mid_position_leak,
    pictures,
    printed_friction,
    printed_polynomial,
)
from rodless_lab.experiments.experiment import Experiment
from rodless_lab.experiments.result import Comparison, Limits, Picture
from rodless_lab.experiments.valve_area import RATED, rated_flow
from rodless_lab.experiments.valve_stand import FREE_AIR_DENSITY
from rodless_lab.identification.valve_bench.area_curve import effective_area as area_of_flow
from rodless_sim import RigParameters, simulate
from rodless_sim.physics.cylinder import pressure_rate
from rodless_sim.physics.flow import LAMINAR_RATIO, gap_flow, orifice_flow
from rodless_sim.physics.friction import sliding_friction
from rodless_sim.physics.valve import (
    SPOOL_GAIN,
    centred_area,
    effective_area,
    flow_coefficient,
    spool_displacement,
)
from rodless_sim.physics.valve_assemblies.printed import gap_flow_printed

ARROW = " → "


@dataclass(frozen=True)
class ErrataResult:
    """One row per fault: the number of the form used, beside that of the printed form."""

    comparisons: tuple[Comparison, ...]
    pictures: tuple[Picture, ...]
    remarks: tuple[str, ...] = (
        "The column *paper* holds what the printed form gives for the same quantity. The limits "
        "are the evidence: dimensions, a data sheet, or the authors' own runs. What is printed "
        "and what is used stands in docs/errata.md, row by row.",
        "(28): results do not depend on α as long as it stays far below v_s; the number is how far "
        "the creep at 5.24 V moves in 20 s when α is a tenth of its value.",
        "No row, because they are words: (8), whose sign (15) corrects; the angular velocity of "
        "(29); the reference in (30); section 7, on which step and sine are judged. x_v in the "
        "gap's length is measured by the force on a held piston at 5.08 V.",
    )


def run_errata() -> ErrataResult:
    """Compute every number of the errata table and prepare its pictures."""
    rows = (
        *valve_rows(),
        *orifice_rows(),
        *gap_rows(),
        *assembly_rows(),
        *coefficient_rows(),
        *chamber_rows(),
        *friction_rows(),
        *force_rows(),
    )
    return ErrataResult(rows, pictures())


def valve_rows() -> Iterator[Comparison]:
    """Table 1, eqs. (4) and (5)."""
    yield Comparison(
        "Table 1: highest supply the valve takes, gauge",
        (RigParameters.DECLARATIONS["supply.pressure"].maximum - STANDARD_ATMOSPHERE) * 1e-6,
        "MPa",
        "100",
        Limits(1.0, 1.1, "Festo MPYE: 0 to 10 bar; the parameter's range ends just above"),
    )
    air = assembled("reconciled").air._replace(temperature=293.15)
    flow = orifice_flow(air, 1e-6, 0.5e6, STANDARD_ATMOSPHERE) / FREE_AIR_DENSITY
    found = area_of_flow(np.array(flow), np.array(0.5e6), np.array(293.15))
    yield Comparison(
        "(4): area found for an ideal nozzle of 1 mm²",
        float(found) * 1e6,
        "mm²",
        "999 (P_u in MPa)",
        Limits(0.99, 1.01, "must be 1; the factor is rounded to 0.124 and air to 1.185 kg/m³"),
        decimals=4,
    )
    valve = assembled("reconciled").valve
    printed = effective_area(valve, CLOSED_VOLTAGE) * 1e6
    yield Comparison(
        "(5): area at the closed position",
        centred_area(valve, 0.0) * 1e6,
        "mm²",
        f"{printed:.5f}, 3.4 times its smallest",
        Limits(0.0, 0.0, "closed at 5.08 V, as section 3.5 says"),
        decimals=5,
    )


def orifice_rows() -> Iterator[Comparison]:
    """Eqs. (6), (7), (19), (20) and the gas constant."""
    air = assembled("reconciled").air
    yield Comparison(
        "(6): flow through 1 mm² from 0.5 MPa against 0.505 MPa",
        orifice_flow(air, 1e-6, 0.5e6, 0.505e6) * 1e3,
        "g/s",
        "not a number",
        Limits(-1.0, -1e-9, "must run backwards"),
        decimals=3,
    )
    yield Comparison(
        "(6): slope of the flow at equal pressures, times that at r = 0.9995",
        slope(0.999999) / slope(0.9995),
        "",
        f"{printed_slope(0.999999) / printed_slope(0.9995):.1f}, without bound",
        Limits(0.99, 1.01, f"linear above r = {LAMINAR_RATIO}"),
    )
    yield Comparison(
        "(6): flow through 1 mm² from 0.6 MPa to atmosphere",
        orifice_flow(air, 1e-6, 0.6e6, STANDARD_ATMOSPHERE) * 1e3,
        "g/s",
        "1.4 · 10⁶ (S in mm²)",
        Limits(1.3, 1.5, "choked nozzle by hand: 0.6847 S P/√(RT) = 1.41 g/s"),
    )
    yield Comparison(
        "R: speed of sound at 297 K",
        math.sqrt(air.isentropic_index * air.gas_constant * 297.0),
        "m/s",
        f"{math.sqrt(1.4 * 8314.32 * 297.0):.0f}",
        Limits(345.0, 346.0, "345.5 m/s in dry air"),
        decimals=1,
    )


def slope(ratio: float) -> float:
    """dṁ/dr in kg/s of 1 mm² at 0.5 MPa between ``ratio`` and 1."""
    air = assembled("reconciled").air
    return orifice_flow(air, 1e-6, 0.5e6, 0.5e6 * ratio) / (1.0 - ratio)


def printed_slope(ratio: float) -> float:
    """The same of the nozzle formula, up to a factor."""
    return math.sqrt(ratio ** (2.0 / 1.4) - ratio ** (2.4 / 1.4)) / (1.0 - ratio)


def gap_rows() -> Iterator[Comparison]:
    """Eqs. (3), (15), (16), (21), (22)."""
    high = absolute(0.6e6)
    factor = (high + STANDARD_ATMOSPHERE) / (2.0 * STANDARD_ATMOSPHERE)
    yield Comparison(
        "(15): gap flow at 0.6 MPa, times the printed one",
        gap_flow(1e-17, high, STANDARD_ATMOSPHERE)
        / gap_flow_printed(1e-17, high, STANDARD_ATMOSPHERE),
        "",
        "1",
        Limits(0.999 * factor, 1.001 * factor, "compressible slit: (P1 + P2)/(2 P2)"),
        decimals=3,
    )
    yield Comparison(
        "(3): leak of the closed valve at 0.6 MPa",
        mid_position_leak(assembled("reconciled").valve.gap_height),
        "L/min",
        f"{mid_position_leak(11.5e-6):.1f} (gap of 11.5 µm)",
        Limits(0.0, 7.0, "the valve's maker states at most 7 L/min"),
    )


def assembly_rows() -> Iterator[Comparison]:
    """The regime switch at 5.08 V, and the spool displacement of eq. (24)."""
    printed, used = assembled("printed"), assembled("reconciled")
    edge = np.array([CLOSED_VOLTAGE - 1e-6, CLOSED_VOLTAGE])
    jump = ARROW.join(f"{force:.0f}" for force in held_force(printed, edge))
    yield Comparison(
        "5.08 V: force on a held piston just above less just below",
        float(np.diff(held_force(used, edge))[0]),
        "N",
        f"jumps {jump} N",
        Limits(-0.01, 0.01, "a force cannot jump with the voltage"),
    )
    forces = held_force(used, np.linspace(4.0, 6.2, 221))
    least = float(np.diff(held_force(printed, np.linspace(4.0, 6.2, 221))).min())
    yield Comparison(
        "5.08 V: smallest rise of that force per 10 mV, 4.0 to 6.2 V",
        float(np.diff(forces).min()),
        "N",
        f"{least:.0f}",
        Limits(0.0, math.inf, "more voltage must not push backwards"),
        decimals=3,
    )
    run = np.array([5.24])
    yield Comparison(
        "5.24 V: settled force on a held piston",
        float(held_force(used, run)[0]),
        "N",
        f"{held_force(printed, run)[0]:.0f}; yet their run went forward (Fig. 13)",
        Limits(29.0, math.inf, "must break 29 N of static friction loose, forwards"),
        decimals=1,
    )
    yield Comparison(
        "(24): voltage at which the spool is centred",
        float(np.interp(0.0, [spool_displacement(u) for u in (0.0, 10.0)], [0.0, 10.0])),
        "V",
        f"{-PRINTED_OFFSET / SPOOL_GAIN:.2f}",
        Limits(4.98, 5.18, "the closed position, 5.08 V ± 0.1 V"),
    )


def coefficient_rows() -> Iterator[Comparison]:
    """Eq. (25) in its three readings."""
    plant = assembled("reconciled")
    volts = [printed_polynomial(plant, d) for d in np.linspace(-5.0, 4.92, 200)]
    used = [flow_coefficient(plant.valve, d) for d in np.linspace(-5.0, 4.92, 200)]
    yield Comparison(
        "(25): smallest C_v, 0 to 10 V",
        min(used),
        "",
        f"{min(volts):.1f} (volts, branches as printed)",
        Limits(0.5, 1.132, "a flow coefficient is positive, and Fig. 11's falls with opening"),
        decimals=3,
    )
    metres = printed_polynomial(plant, spool_displacement(10.0))
    yield Comparison(
        "(25): fall of C_v from closed to 10 V",
        flow_coefficient(plant.valve, 0.0) - flow_coefficient(plant.valve, 4.92),
        "",
        f"{1.132 - metres:.5f} (metres, as printed)",
        Limits(0.05, 1.0, "section 3.5: smaller and smaller"),
        decimals=3,
    )
    printed = rated_flow(assembled("printed"))[0] * 6e4
    yield Comparison(
        "(25): rated flow at 10 V",
        rated_flow(plant)[0] * 6e4,
        "L/min",
        f"{printed:.0f} (metres, as printed)",
        RATED,
        decimals=1,
    )


def chamber_rows() -> Iterator[Comparison]:
    """Eq. (26), kept as printed: its energy is right for filling only."""
    air = assembled("reconciled").air
    stored = (
        1e-4
        * pressure_rate(air, 1e-4, 0.0, STANDARD_ATMOSPHERE, 1.0)
        / (air.isentropic_index - 1.0)
    )
    carried = 3.5 * air.gas_constant * air.temperature
    yield Comparison(
        "(26): energy that a kilogram brings into a chamber, over its enthalpy c_p T_s",
        stored / carried,
        "",
        "1, the same for outflow whatever the chamber's temperature",
        Limits(0.999, 1.001, "energy balance of filling; kept as printed"),
        decimals=3,
    )


def friction_rows() -> Iterator[Comparison]:
    """Eqs. (28), (29) and Table 2."""
    yield Comparison(
        "(28): change of a 20 s creep at 5.24 V when α is a tenth",
        abs(creep(1e-5) - creep(1e-6)) * 1e6,
        "µm",
        "α has no value",
        Limits(0.0, 5.0, "a quarter of the displacement sensor's scatter of 20 µm"),
        decimals=3,
    )
    friction = assembled("reconciled").friction
    velocity = -1e-3
    yield Comparison(
        "Table 2: power that friction takes at −1 mm/s",
        sliding_friction(friction, velocity, -1) * velocity * 1e3,
        "mW",
        f"{printed_friction(velocity) * velocity * 1e3:.1f}: it drives",
        Limits(0.0, math.inf, "friction takes energy"),
        decimals=1,
    )


def creep(capture_velocity: float) -> float:
    """Distance in m that the carriage creeps in 20 s at 5.24 V and 0.5 MPa gauge."""
    parameters = RigParameters(
        {"supply.pressure": absolute(0.5e6), "friction.capture_velocity": capture_velocity}
    )
    run = simulate(parameters, np.full(20_000, 5.24), 1e-3, position=0.02)
    return float(run.position[-1] - run.position[0])


def force_rows() -> Iterator[Comparison]:
    """Eq. (31): its dimensions and the piston's area."""
    area = assembled("reconciled").cylinder.piston_area
    yield Comparison(
        "(31): piston area",
        area * 1e4,
        "cm²",
        "49.1",
        Limits(4.90, 4.92, "bore of the CY3R25: 25 mm"),
        decimals=3,
    )
    yield Comparison(
        "(31): force at 0.5 MPa",
        area * 0.5e6,
        "N",
        f"{0.00491 * 0.5e6:.0f}",
        Limits(0.0, 363.0, "the magnetic coupling of the CY3R25 holds 363 N"),
        decimals=0,
    )


EXPERIMENT = Experiment(
    name="errata",
    title="What the paper's equations do as printed",
    source="all of it",
    summary="For each fault of the paper that is more than a word, the number or picture that "
    "shows it, beside that of the form used.",
    run=lambda _: run_errata(),
)
