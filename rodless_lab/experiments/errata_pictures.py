# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Pictures of what the paper's equations do as printed, beside the forms used."""

from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rodless_base.constants import CLOSED_VOLTAGE, STANDARD_ATMOSPHERE, absolute
from rodless_lab.experiments.result import Picture
from rodless_lab.experiments.valve_stand import FREE_AIR_DENSITY
from rodless_lab.figures.style import label, panels
from rodless_lab.identification.valve_bench.area_curve import LITRES_PER_MINUTE
from rodless_sim import RigParameters
from rodless_sim.physics.flow import gap_conductance, gap_flow
from rodless_sim.physics.friction import sliding_friction
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.settled import settled_pressures
from rodless_sim.physics.valve import (
    SPOOL_GAIN,
    centred_area,
    effective_area,
    flow_coefficient,
    spool_displacement,
)
from rodless_sim.physics.valve_assemblies.printed import (
    flow_coefficient_printed,
    gap_flow_printed,
)

Array = npt.NDArray[np.float64]

PRINTED: dict[str, Any] = {"color": "tab:red", "linestyle": "--"}
USED: dict[str, Any] = {"color": "tab:blue"}

# Eq. (24) with the offset printed; the digit 1 belongs one place further left.
PRINTED_OFFSET = 0.000108499


def assembled(assembly: str, supply_gauge: float = 0.5e6) -> Plant:
    """Return the constants of an assembly of the valve."""
    return Plant.of(
        RigParameters({"valve.assembly": assembly, "supply.pressure": absolute(supply_gauge)})
    )


def held_force(plant: Plant, voltages: Array) -> Array:
    """Force in N on a held piston once its chambers have settled, shape (n,)."""
    pressures = np.array([settled_pressures(plant, float(voltage)) for voltage in voltages])
    return np.asarray(plant.cylinder.piston_area * (pressures[:, 0] - pressures[:, 1]))


def printed_polynomial(plant: Plant, argument: float) -> float:
    """C_v of eq. (25) with its branches as printed, whatever the unit of the argument."""
    return flow_coefficient_printed(plant.valve, argument)


def pictures() -> tuple[Picture, ...]:
    """All pictures of the errata."""
    return (
        Picture(
            "errata_held_piston",
            "5.08 V: settled force on a held piston at 0.5 MPa; as printed it jumps backwards",
            draw_held_piston,
        ),
        Picture(
            "errata_area",
            "(5): the measured curve is smallest 0.16 V above the closed position",
            draw_area,
        ),
        Picture("errata_spool", "(24): spool displacement, printed and with its zero", draw_spool),
        Picture("errata_coefficient", "(25): C_v in its three readings", draw_coefficient),
        Picture(
            "errata_gap",
            "(15): gap flow to atmosphere, density held downstream or following the pressure; "
            "(3): leakage at mid-position",
            draw_gap,
        ),
        Picture("errata_friction", "Table 2: friction with the signs printed", draw_friction),
    )


def closed_line(axes: Axes) -> None:
    """Mark the closed position."""
    axes.axvline(CLOSED_VOLTAGE, color="0.5", linewidth=0.8, label="closed position, 5.08 V")


def draw_held_piston() -> Figure:
    """Draw settled force against voltage for both assemblies."""
    figure, (axes,) = panels(1, height=2.8)
    below = np.linspace(4.0, CLOSED_VOLTAGE, 200, endpoint=False)
    above = np.linspace(CLOSED_VOLTAGE, 6.2, 200)
    for name, style in (("printed", PRINTED), ("reconciled", USED)):
        plant = assembled(name)
        voltages = np.concatenate([below, above])
        axes.plot(voltages, held_force(plant, voltages), **style, label=f"{name} assembly")
    axes.axhline(0.0, color="k", linewidth=0.6, label="_zero")
    axes.axvline(
        5.24,
        color="k",
        linestyle="-.",
        linewidth=0.8,
        label="5.24 V: here the authors' carriage ran forward",
    )
    closed_line(axes)
    label(axes, "valve voltage / V", "settled force / N")
    return figure


def draw_area() -> Figure:
    """Draw the measured area and the re-centred one."""
    figure, (axes,) = panels(1, height=2.7)
    valve = assembled("reconciled").valve
    voltages = np.linspace(4.6, 5.8, 400)
    printed = [effective_area(valve, u) * 1e6 for u in voltages]
    axes.plot(voltages, printed, **PRINTED, label="as printed")
    used = [centred_area(valve, u - CLOSED_VOLTAGE) * 1e6 for u in voltages]
    axes.plot(voltages, used, **USED, label="re-centred, less its smallest value")
    closed_line(axes)
    label(axes, "valve voltage / V", "effective area / mm²")
    return figure


def draw_spool() -> Figure:
    """Draw eq. (24) with both offsets."""
    figure, (axes,) = panels(1, height=2.5)
    voltages = np.linspace(0.0, 10.0, 50)
    printed = (SPOOL_GAIN * voltages + PRINTED_OFFSET) * 1e3
    axes.plot(voltages, printed, **PRINTED, label="+ 0.000108499 m, as printed")
    used = [spool_displacement(u) * 1e3 for u in voltages]
    axes.plot(voltages, used, **USED, label="− 0.00108499 m, used")
    axes.axhline(0.0, color="k", linewidth=0.6, label="_zero")
    closed_line(axes)
    label(axes, "valve voltage / V", "spool displacement / mm")
    return figure


def draw_coefficient() -> Figure:
    """Draw eq. (25) read in metres, in volts as printed, and in volts with branches swapped."""
    figure, (axes,) = panels(1, height=2.8)
    plant = assembled("reconciled")
    voltages = np.linspace(0.1, 10.0, 400)
    metres = [printed_polynomial(plant, spool_displacement(u)) for u in voltages]
    axes.plot(voltages, metres, color="tab:orange", linestyle="-.", label="metres, as printed")
    volts = [printed_polynomial(plant, u - CLOSED_VOLTAGE) for u in voltages]
    axes.plot(voltages, volts, **PRINTED, label="volts, branches as printed")
    used = [flow_coefficient(plant.valve, u - CLOSED_VOLTAGE) for u in voltages]
    axes.plot(voltages, used, **USED, label="volts, branches swapped: used")
    axes.axhline(0.0, color="k", linewidth=0.6, label="_zero")
    axes.set_ylim(-2.0, 2.4)
    label(axes, "valve voltage / V", "flow coefficient C_v", loc="lower center")
    return figure


def draw_gap() -> Figure:
    """Draw gap flow both ways, and the leak at mid-position for both gap heights."""
    figure, (flow, leak) = panels(1, 2)
    plant = assembled("reconciled")
    pressures = np.linspace(0.0, 0.6e6, 100) + STANDARD_ATMOSPHERE
    conductance = gap_conductance(plant.air, np.pi * 6e-3, 6e-6, 2e-3)
    printed = [gap_flow_printed(conductance, p, STANDARD_ATMOSPHERE) * 1e6 for p in pressures]
    used = [gap_flow(conductance, p, STANDARD_ATMOSPHERE) * 1e6 for p in pressures]
    flow.plot((pressures - STANDARD_ATMOSPHERE) * 1e-6, printed, **PRINTED, label="(15) as printed")
    flow.plot((pressures - STANDARD_ATMOSPHERE) * 1e-6, used, **USED, label="compressible, used")
    label(flow, "upstream pressure, gauge / MPa", "flow, gap of 6 µm / (mg/s)")
    for height, style in ((11.5e-6, PRINTED), (6e-6, USED)):
        leaks = [mid_position_leak(height, gauge) for gauge in np.linspace(0.0, 0.6e6, 100)]
        name = f"gap of {height * 1e6:g} µm"
        leak.plot(np.linspace(0.0, 0.6, 100), leaks, **style, label=name)
    leak.axhline(7.0, color="k", linestyle=":", label="maker's bound at 0.6 MPa")
    label(leak, "supply, gauge / MPa", "leak of the closed valve / (L/min)")
    return figure


def mid_position_leak(height: float, supply_gauge: float = 0.6e6) -> float:
    """Free air in L/min through both ports of a closed valve with gaps of ``height`` (m)."""
    air = assembled("reconciled").air
    supply = absolute(supply_gauge)
    between = float(np.sqrt(0.5 * (supply**2 + STANDARD_ATMOSPHERE**2)))
    conductance = gap_conductance(air, np.pi * 6e-3, height, 2e-3)
    return 2.0 * gap_flow(conductance, supply, between) / FREE_AIR_DENSITY * LITRES_PER_MINUTE


def draw_friction() -> Figure:
    """Draw reverse friction with Table 2's signs in eq. (29), and with magnitudes."""
    figure, (axes,) = panels(1, height=2.7)
    friction = assembled("reconciled").friction
    speeds = np.linspace(-8e-3, 0.0, 200, endpoint=False)
    axes.plot(speeds * 1e3, [printed_friction(v) for v in speeds], **PRINTED, label="as printed")
    used = [sliding_friction(friction, v, -1) for v in speeds]
    axes.plot(speeds * 1e3, used, **USED, label="magnitudes, used")
    axes.axhline(0.0, color="k", linewidth=0.6, label="_zero")
    axes.axhspan(0.0, 40.0, color="tab:red", alpha=0.08, label="would drive the motion")
    axes.set_ylim(-60.0, 40.0)
    label(axes, "velocity / (mm/s)", "friction in reverse / N", loc="upper left")
    return figure


def printed_friction(velocity: float) -> float:
    """Eq. (29) in N in reverse with the negative F_s, F_c and v_s of Table 2."""
    drop = (-36.0 + 12.5) * np.exp(-((velocity / -3.6e-3) ** 2))
    return float(4800.0 * velocity - (-12.5 + drop))
