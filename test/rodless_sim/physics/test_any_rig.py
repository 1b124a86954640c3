# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Rigs from all declared ranges at once: whatever the parameters, the motion stays a rig's."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pytest
from extent import draws, some_of

from rodless_base.parameters import Parameter, ParameterError
from rodless_sim import Rig, RigParameters, SimulationError, Trace, simulate

# How plant time passes on a wall clock is no matter of motion; the tolerance is what is compared.
# Free texts, such as a model number, only set others or name things.
OUTSIDE = (
    "time.mode",
    "time.speed",
    "time.duration",
    "time.command_timeout",
    "time.recorders",
    "time.publish_clock",
    "time.tolerance",
)
PAIRS = (
    ("friction.forward.coulomb", "friction.forward.static"),
    ("friction.reverse.coulomb", "friction.reverse.static"),
    ("atmosphere.pressure", "supply.pressure"),
    ("valve.spool_diameter", "valve.sleeve_diameter"),
    ("cylinder.initial_position", "cylinder.stroke"),
    ("time.period", "valve.command_timeout"),
    ("coupling.catch_distance", "coupling.slip_distance"),
    ("chambers.polytropic_index", "air.isentropic_index"),
    ("atmosphere.pressure", "supply.switch_on_pressure"),
    ("supply.switch_on_pressure", "supply.switch_off_pressure"),
)

PRESSURES = (
    "atmosphere.pressure",
    "supply.switch_on_pressure",
    "supply.switch_off_pressure",
    "supply.pressure",
)

# What decides which equations are compiled, which takes a minute each time; the rest is drawn.
# All pairs of options are for test_options.
WITHOUT = {
    "valve.dynamics": "none",
    "valve.hysteresis": 0.0,
    "valve.dead_time": 0.0,
    "tubes.model": "none",
    "supply.kind": "regulated",
    "supply.ripple_amplitude": 0.0,
    "supply.droop": 0.0,
    "coupling.kind": "rigid",
    "friction.dynamics": "static",
    "friction.drift": 0.0,
}
HEATED: dict[str, object] = {"chambers.thermodynamics": "energy_balance"}
SPOOL: dict[str, object] = {"valve.dynamics": "second_order"}
KINDS: tuple[dict[str, object], ...] = (
    {**WITHOUT, "chambers.thermodynamics": "polytropic"},
    {**WITHOUT, **HEATED, **SPOOL},
    {**WITHOUT, "chambers.thermodynamics": "adiabatic", "tubes.model": "delay"},
    {**SPOOL, "friction.dynamics": "lugre", "tubes.model": "none"},
    {**SPOOL, "coupling.kind": "magnetic", "tubes.model": "delay"},
)

DRY = ("static", "coulomb")

# Each keeps the carriage from being moved: one rig in eight has it.
HOLDING = ("cylinder.locked", "fault.carriage.seized", "fault.valve.spool")


def value_of(declared: Parameter, draw: np.random.Generator) -> object:
    """Any value that the declaration allows; of a number now and then an end of its range."""
    choices = (False, True) if isinstance(declared.default, bool) else declared.choices
    if choices:
        return choices[draw.integers(len(choices))]
    # No curve through numbers drawn one by one is a valve's.
    if isinstance(declared.default, tuple):
        return declared.default
    low, high = declared.minimum, declared.maximum
    if isinstance(declared.default, int):
        return int(draw.integers(int(low), int(high), endpoint=True))
    kind = draw.integers(8)
    if kind < 2:
        return (low, high)[kind]
    # By size too: evenly by value nearly all would be of the size of the maximum.
    if low >= 0.0 and kind < 6:
        return float(
            np.clip(math.exp(draw.uniform(*np.log([max(low, 1e-6 * high), high]))), low, high)
        )
    return float(draw.uniform(low, high))


def any_rig(draw: np.random.Generator, kind: dict[str, object]) -> RigParameters:
    """Any rig of a kind; raises ParameterError for what no rig can be."""
    values = {
        name: value_of(declared, draw)
        for name, declared in RigParameters.DECLARATIONS.items()
        if name not in OUTSIDE and (declared.choices or not isinstance(declared.default, str))
    }
    values.update(kind)
    for name in HOLDING:
        if draw.integers(8):
            values[name] = RigParameters.DECLARATIONS[name].default
    if values["friction.dynamics"] == "lugre":
        _bristle(values)
    for low, high in PAIRS:
        one, other = float(str(values[low])), float(str(values[high]))
        top = RigParameters.DECLARATIONS[low].maximum
        values[low] = min(one, other, top)
        values[high] = max(one, other, RigParameters.DECLARATIONS[high].minimum)
    atmosphere, least, most, supply = (float(str(values[name])) for name in PRESSURES)
    if values["supply.kind"] == "compressor":
        values["supply.pressure"] = supply = min(max(supply, least), most)
    ripple = float(str(values["supply.ripple_amplitude"]))
    values["supply.ripple_amplitude"] = min(ripple, supply - atmosphere)
    if values["coupling.kind"] == "rigid":
        values["fault.carriage.decoupled"] = False
    diameter, length = (float(str(values[f"tubes.{of}"])) for of in ("diameter", "length"))
    if values["tubes.model"] != "none":
        for volume in ("cylinder.dead_volume_a", "cylinder.dead_volume_b"):
            values[volume] = max(float(str(values[volume])), 0.8 * diameter**2 * length)
    index = float(str(values["air.isentropic_index"]))
    values["air.critical_ratio"] = (2.0 / (index + 1.0)) ** (index / (index - 1.0))
    values["time.period"] = max(round(float(str(values["time.period"])), 6), 1e-4)
    return RigParameters(values)


def _bristle(values: dict[str, object]) -> None:
    """Let the bristles bear something at any speed, both ways: docs/options/lugre.md, limits."""
    names = [f"friction.{way}.{of}" for way in ("forward", "reverse") for of in DRY]
    least = 0.05 * max(float(str(values[name])) for name in names)
    values.update({name: max(float(str(values[name])), least) for name in names})


class Case(NamedTuple):
    """A rig, and what is done with it."""

    parameters: RigParameters
    voltages: list[float]  # V, each held as long as the others
    coarse: Trace  # with a tolerance of 1
    fine: Trace  # of 0.01


def run(parameters: RigParameters, voltages: list[float], start: float, tolerance: float) -> Trace:
    """A quarter of a second, or four periods, from ``start``, a share of the stroke."""
    period = parameters.number("time.period")
    each = max(1, round(0.25 / period / len(voltages)))
    position = start * parameters.number("cylinder.stroke")
    chosen = parameters.with_values({"time.tolerance": tolerance})
    return simulate(chosen, np.repeat(voltages, each), period, position)


def cases(kind: int) -> Iterator[Case]:
    """Rigs of a kind, drawn by number: the same on every machine and in every run.

    Refused are combinations that no rig has. Heated chambers that leak may not be found to settle,
    and tubes may draw a chamber empty: both are said, and left out. At most as many again are. Of
    rigs with bristles or a piston of its own a few, at the ends of many ranges at once, are said to
    be too fast to follow.
    """
    found = lost = 0
    for number in range(2 * MANY):
        draw = np.random.default_rng([kind, number])
        try:
            parameters = any_rig(draw, KINDS[kind])
            voltages = draw.uniform(0.0, 10.0, draw.integers(1, 5)).tolist()
            start = float(draw.random())
            coarse, fine = (
                run(parameters, voltages, start, tolerance) for tolerance in (1.0, 0.01)
            )
        except ParameterError:
            continue
        except SimulationError as error:
            if kind in WITH_MORE_STATES and "too fast to follow" in str(error):
                lost += 1
            elif not any(words in str(error) for words in SAID):
                raise
            continue
        yield Case(parameters, voltages, coarse, fine)
        found += 1
        if found == MANY:
            assert lost <= MOST_LOST
            return
    raise AssertionError(f"of {2 * MANY} rigs only {found} ran")


MANY = draws(40, 10)
WITH_MORE_STATES, MOST_LOST = (3, 4), 4
SAID = ("check the leak.*, or give pressures", "tubes draw air from a chamber")


@pytest.mark.slow
@pytest.mark.parametrize("kind", some_of(range(len(KINDS)), 4))
def test_motion_stays_that_of_a_rig(kind: int) -> None:
    """Finite, within the stroke, pressures positive; what the instruments read is finite too.

    The error is small: within 5 µm of the run with a hundredth of the tolerance. And the rigs are
    not one: they reach from end to end of ranges, and many move.
    """
    bores, travels = [], []
    for parameters, voltages, coarse, fine in cases(kind):
        for name, values in coarse.columns().items():
            assert np.isfinite(values).all(), name
        assert coarse.position.min() >= 0.0
        assert coarse.position.max() <= parameters.number("cylinder.stroke")
        assert min(coarse.pressure_a.min(), coarse.pressure_b.min()) > 0.0
        rig = Rig(parameters)
        rig.advance(voltages[0], parameters.number("time.period"))
        seen = rig.read()
        for name in ("position", "pressure_a", "pressure_b", "supply_pressure"):
            gone = parameters[f"fault.{name}.sensor"] == "gone"
            assert math.isnan(getattr(seen, name)) if gone else math.isfinite(getattr(seen, name))
        assert np.abs(coarse.position - fine.position).max() < 5e-6
        bores.append(parameters.number("cylinder.bore"))
        travels.append(float(np.ptp(coarse.position)))
    assert max(bores) > 0.05
    assert min(bores) < 0.01
    assert np.mean(np.array(travels) > 1e-4) > 0.05
