# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The preset ``calibrated`` on a test stand: each figure as its data sheet defines it.

Valve: Festo MPYE-5-M5-010-B. Cylinder: SMC CY3R25. The commands are those of a stand, open loop.
"""

import math

import numpy as np
import pytest

from rodless_sim import Rig, RigParameters, Trace, simulate
from rodless_sim.instruments.instruments import DATA_SHEET
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import edge_flow, openings

CALIBRATED = RigParameters.preset("calibrated")
GAUGE = 101325.0
LITRES_PER_MINUTE = 60e3 / 1.185  # of free air for 1 kg/s, ISO 8778
PERIOD = 1e-3
OPEN = {"forward": (10.0, 0.0), "reverse": (0.0, 0.2)}  # V, and where a full stroke starts (m)


def stroke(voltage: float, start: float, gauge: float = 0.52e6, seconds: float = 4.0) -> Trace:
    """From rest at one end, the valve held at ``voltage``, at a supply of ``gauge`` Pa."""
    rig = CALIBRATED.with_values({"supply.pressure": gauge + GAUGE})
    return simulate(rig, np.full(round(seconds / PERIOD), voltage), PERIOD, start)


def in_mid_stroke(run: Trace) -> np.ndarray:
    """Speeds (m/s) from 50 to 150 mm: neither the start nor the air cushion before the cap."""
    speeds: np.ndarray = np.abs(run.velocity[(run.position > 0.05) & (run.position < 0.15)])
    return speeds


@pytest.mark.parametrize("way", OPEN)
def test_it_runs_at_500_mm_per_s_and_not_much_faster(way: str) -> None:
    """SMC: 50 to 500 mm/s. Wide open it is beyond 500 mm/s at 0.52 MPa, without any load but 1 kg.

    What ends it is the exhaust: through a choked orifice a volume leaves in which the pressure has
    no say, C_v S ψ* √(R T) at most, and the piston sweeps no more.
    """
    run = stroke(*OPEN[way])
    opening = openings(Plant.of(CALIBRATED), OPEN[way][0]).opening.orifice_area
    choked = math.sqrt(1.4 * (2.0 / 2.4) ** (2.4 / 0.4))
    limit = opening * choked * math.sqrt(287.05 * 297.0) / (math.pi / 4.0 * 0.025**2)
    assert in_mid_stroke(run).mean() > 0.5
    assert 0.85 * limit < np.abs(run.velocity).max() < 1.02 * limit


@pytest.mark.parametrize(("way", "least", "most"), [("forward", 5.3, 6.2), ("reverse", 4.0, 4.8)])
def test_it_runs_smoothly_at_50_mm_per_s(way: str, least: float, most: float) -> None:
    """At the slow end of its range it neither sticks nor swings: within 15 % of its mean speed.

    The voltage is found by bisection. As one chamber grows and the other shrinks, the speed drifts.
    """
    start = OPEN[way][1]
    for _ in range(10):
        voltage = 0.5 * (least + most)
        speeds = in_mid_stroke(stroke(voltage, start, seconds=8.0))
        fast = len(speeds) > 0 and speeds.mean() > 0.05
        forward = way == "forward"
        least, most = (least, voltage) if fast == forward else (voltage, most)
    assert speeds.mean() == pytest.approx(0.05, rel=0.03)
    assert np.abs(speeds / speeds.mean() - 1.0).max() < 0.15


def reaches_50_mm_per_s(way: str, gauge: float) -> bool:
    """Whether the empty carriage runs through mid-stroke at 50 mm/s or more."""
    run = stroke(*OPEN[way], gauge, seconds=6.0)
    speeds = in_mid_stroke(run)
    through = bool(np.ptp(run.position) > 0.19)
    return through and float(speeds.min()) > 0.05


@pytest.mark.parametrize("way", OPEN)
def test_the_minimum_operating_pressure_is_0_16_to_0_18_mpa(way: str) -> None:
    """SMC: the least supply that moves the unloaded piston smoothly through its stroke.

    Smoothly is at the slow end of its range of speeds, 50 mm/s. The carriage breaks away at
    0.06 MPa already (F_s/A), but creeps.
    """
    assert not reaches_50_mm_per_s(way, 0.16e6)
    assert reaches_50_mm_per_s(way, 0.18e6)


def test_the_valve_passes_100_l_per_min() -> None:
    """Festo, standard nominal flow rate: 100 L/min ± 10 % of free air from 6 to 5 bar gauge.

    The same through each of the four ways.
    """
    plant = Plant.of(CALIBRATED)
    for voltage in (0.0, 10.0):
        opening = openings(plant, voltage).opening
        flow = edge_flow(plant, opening, 6e5 + GAUGE, 5e5 + GAUGE)
        assert 90.0 < flow * LITRES_PER_MINUTE < 110.0


def test_the_closed_valve_leaks_7_l_per_min_at_most() -> None:
    """Festo: leakage of free air at 6 bar gauge with the spool in mid-position; it does leak."""
    rig = Rig(CALIBRATED.with_values({"supply.pressure": 6e5 + GAUGE}))
    assert 0.5 < rig.free_air_flow * 60e3 <= 7.0


def swing(frequency: float) -> float:
    """Amplitude of the spool over that of a sine of the whole stroke, 0 to 10 V."""
    period = 1e-4
    rig = CALIBRATED.with_values({"cylinder.locked": True, "time.period": period})
    time = np.arange(round(0.4 / period)) * period
    run = simulate(rig, 5.0 + 5.0 * np.sin(2.0 * np.pi * frequency * time), period, 0.1)
    late = run.time >= 0.2
    angle = 2.0 * np.pi * frequency * run.time[late]
    waves = np.column_stack([np.sin(angle), np.cos(angle), np.ones_like(angle)])
    found = np.linalg.lstsq(waves, run.spool_voltage[late], rcond=None)[0]
    return float(np.hypot(found[0], found[1])) / 5.0


def test_the_spool_is_3_db_down_at_115_hz() -> None:
    """Festo, critical frequency: 115 Hz at the whole stroke of the spool, within 1 %."""
    assert swing(114.0) > math.sqrt(0.5) > swing(116.0)
    assert swing(5.0) == pytest.approx(1.0, abs=0.01)


def test_the_spool_has_a_hysteresis_of_0_4_percent() -> None:
    """Festo: 0.4 % of the stroke lie between the upward and the downward way to one place."""
    ramp = np.concatenate([np.linspace(4.0, 6.0, 2000), np.linspace(6.0, 4.0, 2000)])
    run = simulate(CALIBRATED.with_values({"cylinder.locked": True}), ramp, PERIOD, 0.1)
    up, down = slice(100, 2000), slice(2100, 4000)  # under way
    # The ramp climbs 1 mV per ms, so that the lag of the spool, some 2 ms, is 2 mV to either side.
    upward = np.interp(5.0, run.spool_voltage[up], ramp[up])
    downward = np.interp(5.0, run.spool_voltage[down][::-1], ramp[down][::-1])
    lag = 2.0 * 2.0 * 0.7071 / (2.0 * math.pi * 115.0) * 1.0
    assert upward - downward - lag == pytest.approx(0.004 * 10.0, abs=2.5e-3)


def test_it_is_read_by_the_instruments_of_the_paper() -> None:
    """Those of config/sensors, value by value."""
    assert {name: CALIBRATED[name] for name in DATA_SHEET} == dict(DATA_SHEET)
