# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A supply that ripples, sinks under the flow drawn, and comes from a compressor."""

import math
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from extent import extensive
from scipy.integrate import solve_ivp

from rodless_base.parameters import ParameterError
from rodless_control import PidParameters, references
from rodless_lab import closed_loop
from rodless_sim import Rig, RigParameters, simulate
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import edge_flow, openings
from rodless_sim.sensors import IDEAL

Array = npt.NDArray[np.float64]

R, T, KAPPA, AMBIENT, SET = 287.05, 297.0, 1.4, 101325.0, 621325.0
FREE_AIR = AMBIENT / (R * 293.15)  # kg/m³
VOLUMES = 15e-6 + math.pi / 4 * 0.025**2 * 0.05, 15e-6 + math.pi / 4 * 0.025**2 * 0.15
HELD = {"fault.carriage.seized": True}
RIPPLE = {"supply.ripple_amplitude": 8e3, "supply.ripple_frequency": 23.0}
DROOP = {"supply.droop": 1.2e7, "supply.time_constant": 0.02}
COMPRESSOR = {
    "supply.kind": "compressor",
    "supply.receiver_volume": 4e-4,
    "supply.switch_on_pressure": 0.6e6,
    "supply.switch_off_pressure": 0.63e6,
    "supply.delivery": 4e-3,
}
# A hole beside the chamber draws steadily.
DRAWN = {"leak.a": 1e-6, "leak.b": 1e-6}


class Apart:
    """The same held rig for scipy's Radau: both chambers, the supply at the valve, the receiver."""

    def __init__(self, values: dict[str, Any]) -> None:
        """Take the options."""
        self.plant, self.values = Plant.of(RigParameters(values)), values
        self.droop = values.get("supply.droop", 0.0) / FREE_AIR
        self.compressor = values.get("supply.kind") == "compressor"

    def edges(self, voltage: float) -> tuple[Any, Any]:
        """The edges from the supply to A and to B."""
        lands = openings(self.plant, voltage)
        found = lands.opening, lands.closing
        return found if lands.forward else found[::-1]

    def rate(self, time: float, s: Array, edges: tuple[Any, Any], running: bool) -> list[float]:
        """Of all four."""
        amplitude = self.values.get("supply.ripple_amplitude", 0.0)
        source = s[3] if self.compressor else SET
        source += amplitude * math.sin(2 * math.pi * self.values.get(FREQUENCY, 0.0) * time)
        supply = s[2] if self.droop else source
        drawn, found = 0.0, []
        for side in (0, 1):
            into = edge_flow(self.plant, edges[side], supply, s[side])
            out = edge_flow(self.plant, edges[1 - side], s[side], AMBIENT)
            drawn += into
            found.append(KAPPA * R * T / VOLUMES[side] * (into - out))
        sags = (source - self.droop * drawn - s[2]) / 0.02 if self.droop else 0.0
        delivered = 4e-3 * FREE_AIR if running else 0.0
        fills = R * T / 4e-4 * (delivered - drawn) if self.compressor else 0.0
        return [*found, sags, fills]

    def run(self, voltages: Array, start: tuple[float, float]) -> Array:
        """Return the states each millisecond."""

        def switches(_time: float, s: Array, _edges: tuple[Any, Any], running: bool) -> float:
            return float(0.63e6 - s[3] if running else s[3] - 0.6e6)

        switches.terminal, switches.direction = True, -1  # type: ignore[attr-defined]
        running, state, rows = False, np.array([*start, SET, SET]), []
        for k, voltage in enumerate(voltages):
            rows.append(state)
            now, end = k * 1e-3, (k + 1) * 1e-3
            while now < end - 1e-13:
                run = solve_ivp(
                    self.rate,
                    (now, end),
                    state,
                    "Radau",
                    events=switches,
                    args=(self.edges(float(voltage)), running),
                    rtol=1e-9,
                    atol=1e-4,
                    max_step=5e-4,
                )
                now, state = float(run.t[-1]), run.y[:, -1]
                running ^= run.status == 1
        return np.array([*rows, state])


FREQUENCY = "supply.ripple_frequency"


@pytest.mark.parametrize(
    "options",
    [RIPPLE, DROOP, COMPRESSOR, {**RIPPLE, **DROOP, **COMPRESSOR}],
    ids=["ripple", "droop", "compressor", "all"],
)
def test_agrees_with_a_stiff_solver(options: dict[str, Any]) -> None:
    """Both chambers, supply and receiver agree within 5 Pa; the compressor switches meanwhile."""
    values = {**HELD, **options}
    voltages = np.repeat([9.0, 1.0, 9.0], [25, 25, 20])
    run = simulate(RigParameters(values), voltages, 1e-3, 0.05)
    found = Apart(values).run(voltages, (run.pressure_a[0], run.pressure_b[0]))
    plain = simulate(RigParameters(HELD), voltages, 1e-3, 0.05)
    assert np.abs(plain.pressure_a - run.pressure_a).max() > 500.0
    assert np.abs(run.pressure_a - found[:, 0]).max() < 5.0
    assert np.abs(run.pressure_b - found[:, 1]).max() < 5.0
    columns = run.columns()
    assert ("supply_pressure" in columns) == ("supply.droop" in options)
    assert ("receiver_pressure" in columns) == ("supply.kind" in options)
    if "supply.droop" in options:
        assert np.abs(run.supply_pressure - found[:, 2]).max() < 5.0
    if "supply.kind" in options:
        assert np.abs(run.receiver_pressure - found[:, 3]).max() < 5.0
        assert set(run.compressor) == {0.0, 1.0}


def test_the_instruments_show_the_ripple() -> None:
    """P_s + a sin(2π f t) it is, to the bit of a sine, from the reset on."""
    rig = Rig(RigParameters(RIPPLE))
    for _ in range(2):
        rig.reset()
        for k in range(30):
            expected = SET + 8e3 * math.sin(2 * math.pi * 23.0 * k * 1e-3)
            assert rig.read().supply_pressure == pytest.approx(expected, abs=1e-6)
            rig.advance(5.08, 1e-3)


def test_a_supply_sinks_by_the_flow_that_is_drawn() -> None:
    """Steadily by the droop times the free air; the pressure at the valve is what is read."""
    rig = Rig(RigParameters({**HELD, **DROOP, **DRAWN}))
    for _ in range(400):
        rig.advance(6.5, 1e-3)
    flow = rig.free_air_flow
    assert flow > 1e-4
    assert rig.state.supply_pressure == pytest.approx(SET - 1.2e7 * flow, abs=1.0)
    assert rig.read().supply_pressure == rig.state.supply_pressure


def test_a_supply_follows_with_its_time_constant() -> None:
    """After a loss, with the valve sealed, the pressure falls as e^(−t/τ)."""
    sealed = {"valve.gap_height": 1e-9}
    rig = Rig(RigParameters({**HELD, **DROOP, **sealed}))
    rig.configure(rig.parameters.with_values({"fault.supply.loss": 0.5}))
    begin, goal = SET, SET - 0.5 * (SET - AMBIENT)
    for k in range(1, 51):
        rig.advance(5.08, 1e-3)
        expected = goal + (begin - goal) * math.exp(-k * 1e-3 / 0.02)
        assert rig.state.supply_pressure == pytest.approx(expected, abs=1.0)


def test_a_compressor_fills_and_empties_its_receiver_in_time() -> None:
    """Filling takes V ΔP/(R T (q_c − q)), emptying V ΔP/(R T q), for a flow that is known."""
    values = {**HELD, **COMPRESSOR, "leak.a": 1e-6, "valve.gap_height": 1e-9}
    rig = Rig(RigParameters(values))
    switched, flows, before = [], [], rig.state.compressor
    for k in range(3000):
        rig.advance(10.0, 1e-4)
        flows.append(rig.free_air_flow)
        if rig.state.compressor != before:
            before = rig.state.compressor
            switched.append(k)
    emptied, filled = switched[2:4]
    span = 4e-4 * 0.03e6 / (R * T * FREE_AIR)
    for begin, end, delivered in ((switched[1], emptied, 0.0), (emptied, filled, 4e-3)):
        mean = float(np.mean(flows[begin:end]))
        assert (end - begin) * 1e-4 == pytest.approx(span / abs(delivered - mean), abs=2.5e-4)


def test_the_receiver_stays_between_its_pressures() -> None:
    """At the instant of a switch the pressure is that of the switch, not past it."""
    rig = Rig(RigParameters({**COMPRESSOR, **DRAWN}))
    seen = [rig.advance(8.0, 1e-3) for _ in range(300)]
    pressures = [state.receiver_pressure for state in seen]
    assert 0.6e6 - 1e-3 <= min(pressures) <= max(pressures) <= 0.63e6 + 1e-3
    assert min(pressures) < 0.603e6
    assert max(pressures) > 0.627e6


def test_a_lost_supply_loses_ripple_and_receiver_too() -> None:
    """With all of it lost the valve has ambient pressure, whatever the options."""
    for options in (RIPPLE, DROOP, COMPRESSOR, {**RIPPLE, **DROOP, **COMPRESSOR}):
        rig = Rig(RigParameters({**options, "fault.supply.loss": 1.0}))
        rig.advance(7.0, 0.5)
        assert rig.read().supply_pressure == pytest.approx(AMBIENT, abs=2.0)


def test_what_a_fault_takes_of_a_compressors_pressure_it_takes_once() -> None:
    """Half of the gauge pressure, in the line behind a receiver that has all of it.

    So at a start and after a reset under the fault, and where it comes just after the start.
    """
    half = {"fault.supply.loss": 0.5}
    late, early = (Rig(RigParameters({**HELD, **COMPRESSOR, **lost})) for lost in ({}, half))
    late.configure(late.parameters.with_values(half))
    for rig in (late, early):
        for _ in range(2):
            assert rig.state.receiver_pressure == SET
            expected = AMBIENT + 0.5 * (SET - AMBIENT)
            assert rig.read().supply_pressure == pytest.approx(expected, rel=1e-12)
            rig.reset()


@pytest.mark.parametrize("ripple", [{}, RIPPLE])
def test_a_supply_that_begins_to_sink_goes_on_from_where_it_is(ripple: dict[str, Any]) -> None:
    """That of the receiver, far below supply.pressure, and with a loss; not from the start."""
    rig = Rig(RigParameters({**HELD, **COMPRESSOR, **DRAWN, **ripple, "fault.supply.loss": 0.1}))
    while rig.state.receiver_pressure > 0.605e6:
        rig.advance(8.0, 1e-3)
    before = rig.read().supply_pressure
    assert before < 0.9 * 0.62e6
    rig.configure(rig.parameters.with_values(DROOP))
    assert rig.read().supply_pressure == pytest.approx(before, rel=1e-12)
    rig.advance(8.0, 1e-5)
    assert rig.read().supply_pressure == pytest.approx(before, rel=1e-4)


def test_tubes_are_fed_at_once_by_a_supply_that_has_changed() -> None:
    """What flows is what flows where it was so from the start: chambers and tubes are the same."""
    flows = []
    for pressure in (7e5, 3e5):
        rig = Rig(RigParameters({**HELD, "tubes.model": "delay", "supply.pressure": pressure}))
        rig.reset(pressures=(2e5, 2e5))
        rig.configure(rig.parameters.with_values({"supply.pressure": 3e5}))
        rig.command(10.0)
        flows.append(rig.free_air_flow)
    assert flows[0] == pytest.approx(flows[1], rel=1e-12)


@extensive
def test_rig_simulation_and_loop_have_the_same_bits() -> None:
    """With all that a supply can do, and tubes; and again after a reset."""
    values = {**RIPPLE, **DROOP, **COMPRESSOR, "tubes.model": "delay"}
    parameters = RigParameters.preset("calibrated").with_values({**IDEAL, **values})
    step = references.step(0.0, 0.058, at=0.02)
    loop = closed_loop(parameters, PidParameters.preset("calibrated"), step, 0.2, 1e-3)
    run = simulate(parameters, loop.voltage[:-1], 1e-3)
    for name in ("position", "pressure_a", "supply_pressure", "receiver_pressure"):
        assert np.array_equal(getattr(loop, name), getattr(run, name)), name
    rig = Rig(parameters)
    for _ in range(2):
        rig.reset()
        states = [rig.advance(u, 1e-3) for u in loop.voltage[:-1]]
        assert [s.supply_pressure for s in states] == run.supply_pressure[1:].tolist()


@pytest.mark.parametrize(
    ("values", "named"),
    [
        ({"supply.ripple_amplitude": 1e5, "supply.pressure": 1.5e5}, "supply.ripple_amplitude"),
        ({**COMPRESSOR, "supply.switch_on_pressure": 0.64e6}, "supply.switch_on_pressure"),
        ({**COMPRESSOR, "supply.switch_on_pressure": 6e4}, "supply.switch_on_pressure"),
        ({**COMPRESSOR, "supply.pressure": 5e5}, "supply.pressure"),
        (
            {**COMPRESSOR, "supply.switch_on_pressure": 1.1e5, "supply.ripple_amplitude": 2e5},
            r"supply.ripple_amplitude: 200000 Pa refused, supply.switch_on_pressure \(110000 Pa\)",
        ),
    ],
)
def test_what_no_supply_can_be_is_refused(values: dict[str, Any], named: str) -> None:
    """A ripple below the atmosphere, and pressures that no receiver can keep."""
    with pytest.raises(ParameterError, match=f"^{named}(: | would)"):
        RigParameters(values)
