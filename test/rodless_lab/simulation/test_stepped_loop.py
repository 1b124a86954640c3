# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Closed loops step by step: the numbers of the compiled loop, and what only they know."""

import numpy as np
import pytest

from rodless_base.constants import CLOSED_VOLTAGE
from rodless_base.measurement import Measurement
from rodless_control import PidParameters, ReferencePoint, references
from rodless_control.controller import Law, LawError
from rodless_lab.simulation.closed_loop import ClosedLoopTrace, closed_loop
from rodless_sim import RigParameters, Scenario, simulate
from rodless_sim.instruments.instruments import DATA_SHEET

STEP = references.step(0.0, 0.058, at=0.1)
NEVER = Scenario([(100.0, {"fault.valve.offset": 1.0})])


def run(
    rig: RigParameters | None = None, scenario: object = None, law: object = None
) -> ClosedLoopTrace:
    """The step to 58 mm, its first second."""
    chosen = law or PidParameters()
    return closed_loop(rig or RigParameters(), chosen, STEP, 1.0, 1e-3, scenario=scenario)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "rig",
    [
        RigParameters(),
        RigParameters.preset("calibrated"),
        RigParameters(DATA_SHEET),
        RigParameters({**DATA_SHEET, "fault.position.offset": 1e-3, "fault.pressure_b.noise": 1e3}),
        RigParameters({"chambers.thermodynamics": "energy_balance", "fault.supply.loss": 0.2}),
        RigParameters(
            {
                "valve.dynamics": "second_order",
                "valve.hysteresis": 0.004,
                "valve.dead_time": 1.3e-3,
                "chambers.thermodynamics": "energy_balance",
                "cylinder.model": "CY3R20-300",
            }
        ),
    ],
    ids=["paper", "calibrated", "data sheet", "faulty sensors", "heat, less supply", "late valve"],
)
def test_it_equals_the_compiled_loop(rig: RigParameters) -> None:
    """Every column and term of a run that both can do is the same, bit for bit."""
    compiled, stepped = run(rig), run(rig, NEVER)
    assert stepped.columns().keys() == compiled.columns().keys()
    for name, column in compiled.columns().items():
        assert np.array_equal(stepped.columns()[name], column), name
    assert np.ptp(compiled.position) > 0.02


def test_a_fault_from_the_start_is_one_of_a_scenario_at_0() -> None:
    """Parameters and scenario make the same run."""
    fault = {"fault.valve.offset": 0.1, "sensors.delay": 2e-3}
    given, played = run(RigParameters(fault)), run(scenario=Scenario([(0.0, fault)]))
    assert np.array_equal(given.position, played.position)
    assert np.array_equal(given.voltage, played.voltage)
    assert not np.array_equal(given.position, run().position)


class Watchful(Law):
    """0.1 V per mm of error; tells when it is asked to hold, and what intervals it sees."""

    USES_PRESSURES = False
    TERMS = ("interval",)

    def reset(self) -> None:
        """Forget what was seen."""
        self.holds = 0

    def hold(self) -> None:
        """Count."""
        self.holds += 1

    def update(
        self, measurement: Measurement, reference: ReferencePoint, interval: float
    ) -> tuple[float, ...]:
        """Answer."""
        return 5.08 + 100.0 * (reference.position - measurement.position), interval


def test_a_position_that_is_gone_closes_the_valve_and_the_law_holds() -> None:
    """For as long as it is gone; the next interval spans the gap."""
    gone = [(0.3, {"fault.position.sensor": "gone"}), (0.4, {"fault.position.sensor": "works"})]
    law = Watchful()
    found = run(scenario=Scenario(gone), law=law)
    missing = np.isnan(found.position)
    assert list(np.flatnonzero(missing)) == list(range(300, 400))
    assert np.all(found.voltage[missing] == CLOSED_VOLTAGE)
    assert np.all(np.isnan(found.terms["interval"][missing]))
    assert law.holds == 100
    assert found.terms["interval"][400] == pytest.approx(0.101)
    assert found.voltage[400] != CLOSED_VOLTAGE


def test_a_pressure_that_is_gone_matters_to_a_law_that_uses_it_alone() -> None:
    """Without pressures the law controls on; with them the valve closes."""
    scenario = Scenario([(0.3, {"fault.pressure_a.sensor": "gone"})])
    assert np.array_equal(run(scenario=scenario).position, run().position)

    def function(measurement: Measurement, reference: ReferencePoint) -> float:
        return 5.08 + 100.0 * (reference.position - measurement.position)

    uses = run(scenario=scenario, law=function)
    assert np.all(uses.voltage[300:] == CLOSED_VOLTAGE)
    assert np.all(np.isnan(uses.force[300:]))
    assert np.isfinite(uses.position).all()


def test_a_law_that_answers_nonsense_is_named_with_the_time() -> None:
    """As in the compiled loop."""
    with pytest.raises(LawError, match=r"at 0\.001 s: law .* answered nan V"):
        run(scenario=NEVER, law=lambda m, _: float("nan") if m.stamp else 5.0)  # type: ignore[misc]


@pytest.mark.parametrize(
    "entries",
    [
        [(0.002, {"supply.droop": 1e7})],
        [(0.002, {"supply.droop": 1e7}), (0.004, {"supply.droop": 0.0})],
    ],
    ids=["on", "on and off"],
)
def test_a_droop_of_a_while_is_in_the_trace(entries: list[tuple[float, dict[str, object]]]) -> None:
    """The supply's pressure where it is a state, NaN elsewhere; as an open loop has it."""
    found = closed_loop(
        RigParameters(), PidParameters(), STEP, 6e-3, 1e-3, scenario=Scenario(entries)
    )
    end = 0.0041 if len(entries) == 2 else 0.1
    droops = (found.time > 0.0019) & (found.time < end - 1e-4)
    assert np.array_equal(np.isfinite(found.supply_pressure), droops)
    open_loop = simulate(
        RigParameters(), found.voltage[:-1], 1e-3, scenario=Scenario(entries)
    ).columns()
    assert open_loop.keys() <= found.columns().keys()
    for name, column in open_loop.items():
        assert np.array_equal(column, found.columns()[name], equal_nan=True), name


def test_force_is_that_of_the_bore_of_its_time() -> None:
    """A scenario makes the piston larger; the one before had its own area."""
    voltage = Scenario([(0.3, {"cylinder.bore": 0.03})])
    found = closed_loop(RigParameters(), PidParameters(), STEP, 0.6, 1e-3, scenario=voltage)
    difference = found.pressure_a - found.pressure_b
    pulls = np.abs(difference) > 1e3
    area = np.pi / 4 * np.where(found.time < 0.2995, 0.025, 0.03) ** 2
    assert found.force[pulls] == pytest.approx((area * difference)[pulls])
    assert pulls[found.time < 0.29].any()
    assert pulls[found.time > 0.31].any()
