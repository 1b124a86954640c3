# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Linear models of rigs with faults: as the rig answers, or refused."""

import re

import numpy as np
import pytest
from small_step import LEAD, small_step

from rodless_lab import linearise
from rodless_sim import RigParameters
from rodless_sim.faults import PARAMETERS, READINGS

# Of each fault that a linear model has: rigs, each with a voltage at which they slide.
HONOURED: list[tuple[dict[str, object], float]] = [
    ({"fault.valve.offset": 0.5}, 5.5),
    ({"fault.valve.offset": -0.4}, 5.0),
    ({"fault.valve.offset": 0.5, "valve.dynamics": "second_order"}, 5.5),
    ({"fault.supply.loss": 0.2}, 6.0),
    ({"fault.tube_a.burst": 2e-7}, 6.0),
    ({"fault.tube_b.burst": 2e-7}, 6.0),
    ({"fault.piston.leak": 1e-7}, 6.0),
]
REFUSED = {
    "fault.valve.spool": ("stuck", "stuck_at"),
    "fault.carriage.seized": (True,),
    "fault.carriage.decoupled": (True,),
}
# Without a stuck spool it does nothing.
NOTHING_BY_ITSELF = {"fault.valve.stuck_voltage": 7.0}


def of_sensors() -> dict[str, object]:
    """All faults that sensors can have, at once."""
    return {
        f"fault.{field}.{name}": value
        for field in READINGS
        for name, value in (("sensor", "frozen"), ("offset", 0.05), ("noise", 0.01))
    }


def test_each_fault_is_looked_at_here() -> None:
    """A fault that is new is in the model, refused, or none of its business."""
    honoured = {name for values, _ in HONOURED for name in values}
    known = honoured | {*REFUSED, *NOTHING_BY_ITSELF, *of_sensors()}
    assert {*PARAMETERS} <= known


@pytest.mark.parametrize(("values", "voltage"), HONOURED)
def test_a_rig_with_a_fault_answers_as_its_model_does(
    values: dict[str, object], voltage: float
) -> None:
    """5 mV for 50 ms more on the command, in steady motion: the difference to a run without."""
    parameters = RigParameters(values)
    found = linearise(parameters, 0.1, voltage)
    assert found.point.voltage == voltage
    run, answers = small_step(parameters, found, 0.1)
    assert run.velocity[LEAD] == pytest.approx(found.point.motion.velocity, rel=0.02)
    assert len(answers) >= 4
    for answer, expected in answers[:4]:
        assert np.abs(answer - expected).max() < 0.02 * np.abs(expected).max()


@pytest.mark.parametrize("name", REFUSED)
def test_a_fault_that_no_linear_model_has_is_refused(name: str) -> None:
    """In one line, by its own name, with the value that is none."""
    for value in REFUSED[name]:
        with pytest.raises(ValueError, match=rf"^{re.escape(name)}\b.*") as refusal:
            linearise(RigParameters({name: value}), 0.1, 6.0)
        assert "\n" not in str(refusal.value)
    if name != "fault.carriage.decoupled":  # refused where there are no magnets, as these are
        assert re.search(r"set it to (free|false)$", str(refusal.value))


@pytest.mark.parametrize("values", [of_sensors(), NOTHING_BY_ITSELF])
def test_what_sensors_read_is_not_in_the_model(values: dict[str, object]) -> None:
    """Its states are the true ones."""
    plain, found = (linearise(RigParameters(given), 0.1, 6.0) for given in ({}, values))
    assert np.array_equal(plain.A, found.A)
    assert np.array_equal(plain.B, found.B)
    assert plain.point == found.point


def test_an_offset_that_saturates_the_valve_is_refused() -> None:
    """Beyond 0 and 10 V of the sum, by as much as the line says; what sticks is told both."""
    for offset, beyond, said, taken in (
        (0.5, 9.6, "it is 10.1 V", 9.5),
        (-0.5, 0.4, "it is -0.1 V", 0.5),
    ):
        rig = RigParameters({"fault.valve.offset": offset})
        with pytest.raises(ValueError, match=rf"^voltage {beyond} V refused: .*{said}, and beyond"):
            linearise(rig, 0.1, beyond)
        plain = linearise(RigParameters(), 0.1, taken + offset)
        assert np.array_equal(linearise(rig, 0.1, taken).A, plain.A)
    with pytest.raises(ValueError, match=r"5\.1 V is what fault\.valve\.offset makes of 4\.6 V$"):
        linearise(RigParameters({"fault.valve.offset": 0.5}), 0.1, 4.6)


def test_friction_that_drifts_has_no_linear_model() -> None:
    """Nor a steady motion; without the drift the model is of what friction begins with."""
    drifting = RigParameters({"friction.drift": 0.02})
    with pytest.raises(ValueError, match=r"^friction\.drift: 0\.02 refused, .* set it to 0$"):
        linearise(drifting, 0.1, 6.0)
