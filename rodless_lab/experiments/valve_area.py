# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Section 3.2, Figs. 6-7: effective area of the valve against voltage, from measured flow."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure

from rodless_base.constants import CLOSED_VOLTAGE, absolute
from rodless_lab.experiments.experiment import Experiment
from rodless_lab.experiments.result import Comparison, Limits, Picture, within
from rodless_lab.experiments.valve_stand import (
    FREE_AIR_DENSITY,
    Stand,
    bare_flow,
    interval_row,
    port_flow,
    systematic_share,
)
from rodless_lab.figures.style import label, panels
from rodless_lab.identification.valve_bench.area_curve import (
    LITRES_PER_MINUTE,
    AreaCurve,
    effective_area,
    fit_area_curve,
    three_sines,
)
from rodless_sim import RigParameters
from rodless_sim.instruments.instruments import DATA_SHEET
from rodless_sim.physics.plant import Plant

Array = npt.NDArray[np.float64]

SUPPLY_GAUGE = 0.4e6
SWEEPS = 3
VOLTAGES = np.linspace(0.0, 10.0, 101)
FINE_VOLTAGES = np.linspace(0.0, 10.0, 1001)
NAMES = tuple(
    f"{what} of sine {sine}" for sine in (1, 2, 3) for what in ("amplitude", "frequency", "phase")
)
UNITS = ("mm²", "rad/V", "rad") * 3

# By what a coefficient is the amplitude of, or not: eq. (4) rounds 0.12385 to 0.124.
ROUNDING = {
    "amplitude": "± 0.2 %: the rounded factor of eq. (4) makes every area 0.12 % small",
    "frequency": "± 0.2 %, as for the amplitudes",
    "phase": "± 0.2 %, as for the amplitudes",
}

# Standard rated flow of a directional valve: 6 bar gauge into it, 5 bar gauge behind it.
RATED_INLET, RATED_OUTLET = absolute(0.6e6), absolute(0.5e6)
RATED = Limits(90.0, 110.0, "Festo MPYE-5-M5: 100 L/min ± 10 %")


@dataclass(frozen=True)
class ValveAreaResult:
    """Voltages (n,) in V, measured areas in m² by sweep (3, 2, n): up, then down; their fits.

    ``truth`` holds the nine coefficients the measured valve has, in the fits' units (mm², rad/V,
    rad), ``systematic`` the largest share
    by which the instruments misread all areas alike. ``assemblies`` holds the area
    that the same stand finds on a whole port of each assembly, m², at every 10 mV from 0 to 10 V;
    ``rated`` their flows in m³/s of free air from 6 to 5 bar gauge, forward and reverse.
    """

    voltages: Array
    areas: Array
    truth: Array
    exact: AreaCurve
    noisy: AreaCurve
    systematic: float
    assemblies: dict[str, Array]
    rated: dict[str, tuple[float, float]]

    @property
    def comparisons(self) -> tuple[Comparison, ...]:
        """Coefficients without noise, the curve with it, rated flow."""
        return (*self._coefficient_rows(), *self._noisy_rows(), *self._rated_rows())

    def _coefficient_rows(self) -> Iterator[Comparison]:
        rows = zip(NAMES, self.exact.coefficients, self.truth, UNITS, strict=True)
        for name, found, true, unit in rows:
            yield Comparison(
                f"without noise: {name}",
                found.value,
                unit,
                f"{true:g}",
                within(true, 2e-3, ROUNDING[name.split()[0]]),
                4,
            )

    def _noisy_rows(self) -> Iterator[Comparison]:
        shares = [self.systematic if unit == "mm²" else 0.0 for unit in UNITS]
        found = np.array([estimate.value for estimate in self.noisy.coefficients])
        turns = np.round((found - self.truth) / (2.0 * np.pi))
        same_phase = self.truth + 2.0 * np.pi * np.where(np.array(UNITS) == "rad", turns, 0.0)
        yield interval_row(self.noisy.coefficients, same_phase, shares)
        yield Comparison(
            "with noise: largest distance of the curve from eq. (5)",
            float(np.abs(self.noisy.area(self.voltages) - self._true_areas()).max()) * 1e6,
            "mm²",
            "0",
            Limits(
                0.0,
                self.systematic * float(self._true_areas().max()) * 1e6,
                f"{self.systematic * 100:.1f} % of full opening: gain of the flow meter, bias of "
                "the pressure transmitter",
            ),
            decimals=4,
        )
        fine = np.linspace(4.5, 6.0, 1501)
        yield Comparison(
            "with noise: voltage of the smallest area",
            float(fine[np.argmin(self.noisy.area(fine))]),
            "V",
            "5.24, from eq. (5)",
            Limits(5.19, 5.29, "half of a step of the sweep, 0.1 V, to either side"),
        )

    def _true_areas(self) -> Array:
        return 1e-6 * three_sines(self.truth, self.voltages)

    def _rated_rows(self) -> Iterator[Comparison]:
        for assembly, flows in self.rated.items():
            limits = RATED if assembly == "reconciled" else None
            for direction, flow in zip(("forward", "reverse"), flows, strict=True):
                yield Comparison(
                    f"rated flow, {assembly} assembly, {direction}",
                    flow * LITRES_PER_MINUTE,
                    "L/min",
                    "100 (Table 1)",
                    limits,
                    decimals=1,
                )

    @property
    def pictures(self) -> tuple[Picture, ...]:
        """Area against voltage as in Fig. 7, and the centre enlarged for both assemblies."""
        return (
            Picture(
                "valve_area",
                "Effective area by eq. (4) from three sweeps up and down, the three sines fitted "
                "to their mean, and the distance of the fit from eq. (5)",
                self.draw_area,
            ),
            Picture(
                "valve_area_assemblies",
                "What the same stand finds on a whole port of each assembly, its centre enlarged",
                self.draw_assemblies,
            ),
        )

    def draw_area(self) -> Figure:
        """Draw measured areas, the fit and its error."""
        figure, (area, error) = panels(2)
        up, down = self.areas[:, 0].T * 1e6, self.areas[:, 1].T * 1e6
        for sweeps, marker, colour, name in (
            (up, "^", "tab:blue", "measured, 0 to 10 V"),
            (down, "v", "tab:orange", "measured, 10 to 0 V"),
        ):
            # One entry of the legend for the three.
            names = [name, *(f"_{name}, sweep {count}" for count in range(2, SWEEPS + 1))]
            area.plot(
                self.voltages, sweeps, marker, color=colour, markersize=2.5, alpha=0.6, label=names
            )
        fitted = self.noisy.area(self.voltages)
        area.plot(self.voltages, fitted * 1e6, "k", linewidth=1.0, label="three sines fitted")
        difference = (fitted - self._true_areas()) * 1e6
        band = self.noisy.band(self.voltages) * 1e6
        error.fill_between(
            self.voltages, difference - band, difference + band, color="0.85", label="95 % band"
        )
        error.plot(self.voltages, difference, "k", linewidth=1.0, label="fit less eq. (5)")
        error.axhline(0.0, color="tab:red", linewidth=0.8, label="_zero")
        label(area, "valve voltage / V", "effective area / mm²", loc="lower left")
        label(error, "valve voltage / V", "difference / mm²", loc="lower center", ncols=2)
        return figure

    def draw_assemblies(self) -> Figure:
        """Draw eq. (5) and the area of a port in both assemblies."""
        figure, (whole, centre) = panels(2)
        for axes in (whole, centre):
            for assembly, areas in self.assemblies.items():
                axes.plot(FINE_VOLTAGES, areas * 1e6, label=assembly)
            measured = 1e-6 * three_sines(self.truth, FINE_VOLTAGES)
            axes.plot(FINE_VOLTAGES, measured * 1e6, "k:", label="eq. (5)")
            axes.axvline(
                CLOSED_VOLTAGE, color="0.5", linewidth=0.8, label="closed position, 5.08 V"
            )
        centre.set_xlim(4.6, 5.8)
        centre.set_ylim(0.0, 0.1)
        label(whole, "valve voltage / V", "effective area / mm²", loc="upper center")
        label(centre, "valve voltage / V", "effective area / mm²", loc="upper center")
        return figure

    @property
    def remarks(self) -> tuple[str, ...]:
        """What the numbers rest on."""
        return (
            "The stand measures the area of eq. (5) alone: eq. (4) knows no flow coefficient, so "
            "whatever C_v means is already within its area. Yet section 3.5 measures C_v against "
            "that area with the same kind of flow and finds 1.13 to 0.89, where eq. (4) and an "
            "ideal nozzle would give 1. Both assemblies multiply by C_v, as the paper does.",
            "Without noise the nine coefficients come back; with it the curve does, and the "
            "coefficients do not: the two slow sines nearly cancel (2.108 against 2.012 mm²) and "
            "can be traded for each other. Their intervals say so.",
            "Each point of the sweep is 0.1 V apart; the readings of the three sweeps up and down "
            "are averaged before the fit, as in the paper. The paper names no flow meter; one of "
            "200 L/min, 1 % and 0.1 L/min is assumed.",
            "In the reconciled assembly C_v falls faster than the area grows beyond 4.5 V from the "
            "closed position, so that the flow is largest near 0.6 and 9.6 V.",
        )


def run_valve_area(seed: int = 1) -> ValveAreaResult:
    """Sweep 0 → 10 → 0 V at 0.4 MPa gauge three times, noise from ``seed``, and fit eq. (5)."""
    parameters = RigParameters({"supply.pressure": absolute(SUPPLY_GAUGE)})
    plant = Plant.of(parameters)
    exact = effective_area(
        bare_flow(plant, VOLTAGES) / FREE_AIR_DENSITY,
        np.array(plant.supply_pressure),
        np.array(plant.air.temperature),
    )
    instruments = parameters.with_values(DATA_SHEET)
    areas = measured_areas(plant, Stand.specimen(instruments, seed))
    truth = np.array(plant.valve.area_coefficients)
    assemblies = {name: assembled(name) for name in ("reconciled", "printed")}
    return ValveAreaResult(
        VOLTAGES,
        areas,
        truth,
        fit_area_curve(VOLTAGES, exact),
        fit_area_curve(VOLTAGES, areas.mean(axis=(0, 1))),
        systematic_share(instruments),
        {name: port_area(plant) for name, plant in assemblies.items()},
        {name: rated_flow(plant) for name, plant in assemblies.items()},
    )


def assembled(assembly: str) -> Plant:
    """Return the constants of an assembly of the valve at 0.4 MPa gauge."""
    return Plant.of(
        RigParameters({"valve.assembly": assembly, "supply.pressure": absolute(SUPPLY_GAUGE)})
    )


def measured_areas(plant: Plant, stand: Stand) -> Array:
    """Areas in m² as measured, shape (sweep, up or down, voltage), each by ascending voltage."""
    flow = bare_flow(plant, VOLTAGES)
    areas = np.empty((SWEEPS, 2, VOLTAGES.size))
    for sweep, direction in np.ndindex(SWEEPS, 2):
        areas[sweep, direction] = effective_area(
            stand.flow(flow),
            stand.supply(plant.supply_pressure, flow.size),
            np.array(plant.air.temperature),
        )
    return areas


def port_area(plant: Plant) -> Array:
    """Area in m² that eq. (4) finds on a whole port, orifice, gap and C_v together."""
    return effective_area(
        port_flow(plant, FINE_VOLTAGES) / FREE_AIR_DENSITY,
        np.array(plant.supply_pressure),
        np.array(plant.air.temperature),
    )


def rated_flow(plant: Plant) -> tuple[float, float]:
    """Flow in m³/s of free air at 10 and 0 V from 6 to 5 bar gauge."""
    supplied = plant._replace(supply_pressure=RATED_INLET)
    forward, reverse = port_flow(supplied, np.array([10.0, 0.0]), RATED_OUTLET) / FREE_AIR_DENSITY
    return float(forward), float(reverse)


EXPERIMENT = Experiment(
    name="valve-area",
    title="Effective area of the valve",
    source="section 3.2, Figs. 6 and 7, eqs. (4) and (5)",
    summary="The supply is held at 0.4 MPa and the voltage swept from 0 to 10 V and back, three "
    "times, while a port blows to atmosphere through a flow meter. Eq. (4) makes an area "
    "of the flow; three sines are fitted to its mean.",
    run=lambda options: run_valve_area(options.seed),
    takes=("seed",),
)
