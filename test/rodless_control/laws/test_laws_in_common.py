# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What every law of the package does alike: limits, new gains, gaps, resets and a start at rest."""

import itertools
import math
import sys
from typing import Any

import pytest

from rodless_control import Measurement, ReferencePoint
from rodless_control.controller import CompiledLaw
from rodless_control.laws import LAWS, law_class
from rodless_control.laws.adrc import Adrc
from rodless_control.laws.cascade import Cascade

# The PID has tests of its own for all of this; mode_switching is made of it and the cascade.
OTHERS = [name for name in LAWS if name not in ("pid", "mode_switching")]

# The laws with an integral, and the parts whose integral it is.
WITH_INTEGRAL = {
    "pid": ("controller",),
    "state_feedback": ("state_feedback",),
    "cascade": ("cascade",),
    "mode_switching": ("controller", "cascade"),
    "sliding_mode": ("sliding_mode",),
}

INTERVAL = 1e-3
LARGEST = sys.float_info.max
HOSTILE = (0.0, 0.05, -0.05, 1e3, -1e9, 1e308, -1e308, LARGEST, -LARGEST, 5e-324)

# Of each law a change that acts at once, and back.
CHANGES = {
    "state_feedback": {"state_feedback.position_gain": 300.0},
    "cascade": {"cascade.position_gain": 1000.0},
    "sliding_mode": {"sliding_mode.boundary_layer": 0.02},
    "adrc": {"adrc.input_gain": 20.0},
}


def made(name: str, **changes: float) -> Any:
    """Return a law with its own default parameters, but for ``changes``."""
    law = law_class(name)
    assert issubclass(law, CompiledLaw)
    return law(changes)


def sample(k: int) -> tuple[Measurement, ReferencePoint]:
    """Sample ``k`` of a slow move with noise, 0.2 mm behind its reference."""
    position = 0.05 + 1e-5 * k + 5e-6 * (-1) ** k
    pressures = 3.2e5 + 100.0 * k, 3.1e5 - 80.0 * k, 6e5
    return Measurement(k * 1_000_000, position, *pressures), ReferencePoint(0.0502 + 1e-5 * k, 0.01)


def running(name: str) -> Any:
    """Return a law in the middle of a move, not at a limit."""
    law = made(name)
    for k in range(60):
        command = law.update(*sample(k), INTERVAL)
    assert 0.5 < command.voltage < 9.5
    return law


@pytest.mark.parametrize("name", OTHERS)
def test_the_terms_are_those_declared(name: str) -> None:
    """Each TERM is a field of the answer, finite, and the answer begins with the voltage."""
    law = running(name)
    command = law.update(*sample(60), INTERVAL)
    assert command._fields == ("voltage", *law.TERMS)
    assert all(map(math.isfinite, command))


@pytest.mark.parametrize("name", OTHERS)
def test_a_carriage_at_rest_where_it_is_wanted_is_left_alone(name: str) -> None:
    """The first command and those that follow are the neutral voltage, with equal pressures."""
    law = made(name)
    for k in range(50):
        measurement = Measurement(k * 1_000_000, 0.1, 3e5, 3e5, 6e5)
        command = law.update(measurement, ReferencePoint(0.1), INTERVAL if k else 0.0)
        assert command.voltage == pytest.approx(5.08, abs=1e-9)


@pytest.mark.parametrize("name", WITH_INTEGRAL)
def test_what_has_wound_up_does_not_hold_the_carriage_away_for_good(name: str) -> None:
    """Held short of its target, then beyond it, the command becomes that of a law held there only.

    So it goes while the air is off: the integral works for minutes, and throws the carriage past
    the zone it works in when the air comes back.
    """
    zone = 3e-4
    zones = {f"{part}.integral_zone": zone for part in WITH_INTEGRAL[name]}
    wound, fresh = made(name, **zones), made(name, **zones)
    target = ReferencePoint(0.1)
    short, beyond = (Measurement(0, 0.1 + way, 3e5, 3e5, 6e5) for way in (-0.9 * zone, 1.2 * zone))
    wound.update(short, target, 0.0)
    for _ in range(6000):
        wound.update(short, target, 1e-2)
    fresh.update(beyond, target, 0.0)
    differences = []
    for _ in range(12_000):
        expected = fresh.update(beyond, target, 1e-2).voltage
        differences.append(wound.update(beyond, target, 1e-2).voltage - expected)
    assert max(differences) > 0.05
    assert differences[-1] == pytest.approx(0.0, abs=1e-6)
    assert 0.0 < expected < 5.08


@pytest.mark.parametrize("name", OTHERS)
def test_no_finite_input_leaves_the_limits(name: str) -> None:
    """Readings and references up to the largest float, in any order, give commands in 0-10 V."""
    law = made(name)
    for k, (one, other) in enumerate(itertools.product(HOSTILE, HOSTILE)):
        measurement = Measurement(0, one, other, HOSTILE[k % 7], HOSTILE[k % 9])
        reference = ReferencePoint(other, HOSTILE[k % len(HOSTILE)])
        command = law.update(measurement, reference, (1e-3, 1e-9, 0.0, 10.0)[k % 4])
        assert 0.0 <= command.voltage <= 10.0
    rest = Measurement(0, 0.1, 3e5, 3e5, 6e5)
    for _ in range(3000):
        command = law.update(rest, ReferencePoint(0.1), INTERVAL)
    assert command.voltage == pytest.approx(5.08, abs=0.7)
    law.reset()
    assert law.update(rest, ReferencePoint(0.1), 0.0).voltage == pytest.approx(5.08, abs=1e-9)


@pytest.mark.parametrize("name", OTHERS)
def test_the_limits_are_those_of_the_parameters(name: str) -> None:
    """A step either way asks for no more than 4.5 or 6 V."""
    limits = {"controller.minimum_voltage": 4.5, "controller.maximum_voltage": 6.0}
    for side, expected in ((1.0, 6.0), (-1.0, 4.5)):
        law = made(name, **limits)
        for k in range(20):
            measurement = Measurement(k * 1_000_000, 0.1, 3e5, 3e5, 6e5)
            reference = ReferencePoint(0.1 + side * 0.05)
            command = law.update(measurement, reference, INTERVAL if k else 0.0)
        assert command.voltage == expected


def steady_commands(
    law: CompiledLaw, change: dict[str, float], pressure_a: float, ahead: float = 0.0
) -> list[Any]:
    """Commands to a carriage at 0.1 m/s that is where it should be, with a ``change`` after 0.6 s.

    The reference is ``ahead`` (m) of it for the first 50 ms; ``pressure_a`` in Pa, 4 bar in B.
    """
    commands = []
    for k in range(1000):
        if k == 600:
            law.configure(law.parameters.with_values(change))
        place = 0.02 + 0.1e-3 * k
        sample = Measurement(k * 1_000_000, place, pressure_a, 4e5, 6.2e5)
        reference = ReferencePoint(place + (ahead if k < 50 else 0.0), 0.1)
        commands.append(law.update(sample, reference, 1e-3 if k else 0.0))
    return commands


@pytest.mark.parametrize("value", [0.7, 2.8])
def test_another_mass_moves_no_effort_of_a_cascade_that_follows(value: float) -> None:
    """At a steady speed all of the force is friction, whatever the mass: the effort stays.

    Left to the filter, the acceleration that the force explains of another mass would be found out
    within some 10 ms, and the offset that has hidden it would be a jump of 30 N by then.
    """
    law = Cascade()
    commands = steady_commands(law, {"cascade.mass": value}, pressure_a=5.6e5)
    efforts = [command.demanded_force for command in commands]
    assert efforts[599] > 50.0
    assert efforts[600:] == pytest.approx([efforts[599]] * 400, abs=0.5)


@pytest.mark.parametrize("value", [0.0125, 0.05])
def test_another_bore_moves_the_effort_of_a_cascade_at_its_pace(value: float) -> None:
    """At a steady speed a share of the force is demanded, of another bore that of another force.

    The effort goes there with the tracking time, a straight exponential. Left to the filters, the
    force of twice the bore was found out within 10 ms, and was a jump of 110 N by then.
    """
    law = Cascade()
    commands = steady_commands(law, {"cascade.bore": value}, pressure_a=5.6e5)
    efforts = [command.demanded_force for command in commands]
    rejection = law.parameters.number("cascade.rejection")
    more = rejection * 1.6e5 * math.pi / 4.0 * (value**2 - 0.025**2)
    tracking = law.parameters.number("cascade.tracking_time")
    expected = [efforts[599] + more * -math.expm1(-1e-3 * k / tracking) for k in range(1, 401)]
    assert efforts[600:] == pytest.approx(expected, abs=0.5)


@pytest.mark.parametrize("value", [3.0, 12.0])
def test_another_input_gain_moves_no_effort_of_adrc_that_has_arrived(value: float) -> None:
    """Without an error the effort is what holds the disturbance, whatever a volt is taken to make.

    It has one here from an error of the first 50 ms.
    """
    commands = steady_commands(Adrc(), {"adrc.input_gain": value}, pressure_a=4e5, ahead=1e-5)
    efforts = [command.effort for command in commands]
    assert 0.05 < abs(efforts[599]) < 5.0
    assert efforts[600:] == pytest.approx([efforts[599]] * 400, rel=0.02)


@pytest.mark.parametrize("name", OTHERS)
def test_new_gains_make_no_jump(name: str) -> None:
    """The law evaluated again at the same instant gives the same voltage; then the gains act."""
    law = running(name)
    last = sample(59)
    before = law.update(*last, 0.0).voltage
    law.configure(law.parameters.with_values(CHANGES[name]))
    assert law.update(*last, 0.0).voltage == pytest.approx(before, abs=1e-9)
    fresh = made(name, **CHANGES[name])
    fresh.update(*last, 0.0)
    for one in (law, fresh):
        for _ in range(3000):  # 3 s, and the offset has faded: e^-30
            one.update(*last, INTERVAL)
    found, expected = (one.memory.drive for one in (law, fresh))
    assert found.effort - found.integral == pytest.approx(
        expected.effort - expected.integral, rel=1e-6, abs=1e-6
    )


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("state_feedback", {"state_feedback.position_gain": 5e4}),
        ("adrc", {"adrc.input_gain": 1e-2}),
    ],
)
def test_new_gains_that_reach_a_limit_make_no_jump(name: str, changes: dict[str, float]) -> None:
    """What they ask for is beyond what the valve can do; the command stays that of before."""
    law, last = running(name), sample(59)
    before = law.update(*last, 0.0).voltage
    fresh = made(name, **changes)
    for k in range(60):
        alone = fresh.update(*sample(k), INTERVAL)
    assert alone.voltage in (0.0, 10.0)
    law.configure(law.parameters.with_values(changes))
    assert law.update(*last, 0.0).voltage == pytest.approx(before, abs=1e-6)


@pytest.mark.parametrize("name", OTHERS)
def test_the_same_gains_again_change_nothing_at_all(name: str) -> None:
    """Setting a parameter to the value it has keeps every bit; there and back leaves no trace."""
    law, untouched, moved = running(name), running(name), running(name)
    law.configure(law.parameters)
    moved.configure(moved.parameters.with_values(CHANGES[name]))
    moved.configure(untouched.parameters)
    expected = untouched.update(*sample(60), INTERVAL)
    assert law.update(*sample(60), INTERVAL) == expected
    assert list(moved.update(*sample(60), INTERVAL)) == pytest.approx(list(expected), abs=1e-9)


@pytest.mark.parametrize("name", OTHERS)
def test_gains_may_change_before_the_first_sample(name: str) -> None:
    """A law that has seen nothing has nothing to keep continuous."""
    law = made(name)
    law.configure(law.parameters.with_values(CHANGES[name]))
    fresh = made(name, **CHANGES[name])
    assert law.update(*sample(0), 0.0) == fresh.update(*sample(0), 0.0)


@pytest.mark.parametrize("name", OTHERS)
def test_after_a_gap_the_filters_start_anew_and_the_integral_stays(name: str) -> None:
    """No velocity is made up from a jump over a gap."""
    law = running(name)
    integral = law.memory.drive.integral
    law.hold()
    far = Measurement(0, 0.15, 3e5, 3e5, 6e5)
    command = law.update(far, ReferencePoint(0.15), 5.0)
    assert command.velocity == 0.0
    assert law.memory.drive.integral == integral


@pytest.mark.parametrize("name", OTHERS)
def test_reset_makes_the_next_sample_the_first(name: str) -> None:
    """After a reset a used law answers like a new one, sample for sample."""
    used, new = running(name), made(name)
    used.hold()
    used.reset()
    samples = [sample(k) for k in range(5)]
    assert [used.update(*s, INTERVAL) for s in samples] == [
        new.update(*s, INTERVAL) for s in samples
    ]


@pytest.mark.parametrize("name", OTHERS)
def test_a_sample_that_is_not_finite_leaves_no_trace(name: str) -> None:
    """A NaN among the readings makes no finite command, and the next answer is as without it."""
    law, untouched = running(name), running(name)
    measurement, reference = sample(60)
    bad = measurement._replace(position=math.nan)
    assert not math.isfinite(law.update(bad, reference, INTERVAL).voltage)
    assert law.update(measurement, reference, INTERVAL) == untouched.update(
        measurement, reference, INTERVAL
    )


@pytest.mark.parametrize("name", [n for n in OTHERS if n != "adrc"])
def test_the_integral_holds_against_a_limit(name: str) -> None:
    """A carriage that is held 0.1 mm off with the valve at its limit winds nothing up."""
    tight = {
        "controller.minimum_voltage": 5.07,
        "controller.maximum_voltage": 5.09,
        f"{name}.integral_zone": 1.0,
        f"{name}.parking_error": 0.0,
    }
    law = made(name, **tight)
    for k in range(3000):
        measurement = Measurement(k * 1_000_000, 0.1, 3e5, 3e5, 6e5)
        command = law.update(measurement, ReferencePoint(0.1001), INTERVAL if k else 0.0)
    gain = law.parameters.number(f"{name}.integral_gain")
    assert command.voltage == 5.09
    # The sample before the limit is reached may add its share.
    assert 0.0 <= command.integral <= 2.0 * gain * 1e-4 * INTERVAL
