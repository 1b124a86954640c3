# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Rigs from all declared ranges at once: whatever the parameters, the motion stays a rig's."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from rodless_base.parameters import Parameter, ParameterError
from rodless_sim import Rig, RigParameters, SimulationError, Trace, simulate
from rodless_sim.physics.valve import LARGEST_AMPLITUDE, scaled_amplitudes

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


def value_of(declared: Parameter) -> st.SearchStrategy[object]:
    """Any value that the declaration allows."""
    if declared.choices:
        return st.sampled_from(declared.choices)
    if isinstance(declared.default, bool):
        return st.booleans()
    low, high = declared.minimum, declared.maximum
    if isinstance(declared.default, int):
        return st.integers(int(low), int(high))
    number = st.floats(low, high)
    if isinstance(declared.default, tuple):
        return st.one_of(st.just(declared.default), st.tuples(*[number for _ in declared.default]))
    # Evenly by size too: evenly by value nearly all would be of the size of the maximum.
    if low >= 0.0:
        least = math.log(max(low, 1e-6 * high))
        number |= st.floats(least, math.log(high)).map(
            lambda power: min(max(math.exp(power), low), high)
        )
    return number


@st.composite
def rigs(draw: st.DrawFn) -> RigParameters:
    """Any rig at all."""
    values = {
        name: draw(value_of(declared), label=name)
        for name, declared in RigParameters.DECLARATIONS.items()
        if name not in OUTSIDE and (declared.choices or not isinstance(declared.default, str))
    }
    values.update(draw(st.sampled_from(KINDS)))
    for name in HOLDING:
        if draw(st.integers(0, 7)):
            values[name] = RigParameters.DECLARATIONS[name].default
    if values["friction.dynamics"] == "lugre":
        _bristle(values)
    for low, high in PAIRS:
        one, other = float(str(values[low])), float(str(values[high]))
        top = RigParameters.DECLARATIONS[low].maximum
        values[low] = min(one, other, top)
        values[high] = max(one, other, RigParameters.DECLARATIONS[high].minimum)
    # Drawn in mm²: the declared range is that of the angles too.
    amplitudes: Any = values["valve.area_coefficients"]
    if max(map(abs, amplitudes[::3])) > LARGEST_AMPLITUDE:
        values["valve.area_coefficients"] = scaled_amplitudes(amplitudes, -6)
    diameter, length = (float(str(values[f"tubes.{of}"])) for of in ("diameter", "length"))
    if values["tubes.model"] != "none":
        for volume in ("cylinder.dead_volume_a", "cylinder.dead_volume_b"):
            values[volume] = max(float(str(values[volume])), 0.8 * diameter**2 * length)
    index = float(str(values["air.isentropic_index"]))
    values["air.critical_ratio"] = (2.0 / (index + 1.0)) ** (index / (index - 1.0))
    values["time.period"] = max(round(float(str(values["time.period"])), 6), 1e-4)
    try:
        return RigParameters(values)
    except ParameterError:
        assume(False)
        raise


def _bristle(values: dict[str, object]) -> None:
    """Let the bristles bear something at any speed, both ways: docs/options/lugre.md, limits."""
    names = [f"friction.{way}.{of}" for way in ("forward", "reverse") for of in DRY]
    least = 0.05 * max(float(str(values[name])) for name in names)
    values.update({name: max(float(str(values[name])), least) for name in names})


VOLTAGES = st.lists(st.floats(0.0, 10.0), min_size=1, max_size=4)

# The same examples on every machine and in every run.
FEW = settings(
    max_examples=60,
    derandomize=True,
    deadline=None,
    database=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much],
)


def run(parameters: RigParameters, voltages: list[float], start: float, tolerance: float) -> Trace:
    """A quarter of a second, or four periods, from ``start``, a share of the stroke.

    Heated chambers that leak may not be found to settle, and tubes may draw a chamber empty: both
    are refused, and such a rig rejected.
    """
    period = parameters.number("time.period")
    each = max(1, round(0.25 / period / len(voltages)))
    position = start * parameters.number("cylinder.stroke")
    chosen = parameters.with_values({"time.tolerance": tolerance})
    try:
        return simulate(chosen, np.repeat(voltages, each), period, position)
    except SimulationError as error:
        assume("check the leak.*, or give pressures" not in str(error))
        assume("tubes draw air from a chamber" not in str(error))
        raise


@pytest.mark.slow
@FEW
@given(rigs(), VOLTAGES, st.floats(0.0, 1.0))
def test_motion_stays_that_of_a_rig(
    parameters: RigParameters, voltages: list[float], start: float
) -> None:
    """Finite, within the stroke, pressures positive; what the instruments read is finite too."""
    trace = run(parameters, voltages, start, 1.0)
    for name, values in trace.columns().items():
        assert np.isfinite(values).all(), name
    assert trace.position.min() >= 0.0
    assert trace.position.max() <= parameters.number("cylinder.stroke")
    assert min(trace.pressure_a.min(), trace.pressure_b.min()) > 0.0
    rig = Rig(parameters)
    rig.advance(voltages[0], parameters.number("time.period"))
    seen = rig.read()
    for name in ("position", "pressure_a", "pressure_b", "supply_pressure"):
        gone = parameters[f"fault.{name}.sensor"] == "gone"
        assert math.isnan(getattr(seen, name)) if gone else math.isfinite(getattr(seen, name))


@pytest.mark.slow
@FEW
@given(rigs(), VOLTAGES, st.floats(0.0, 1.0))
def test_the_error_is_small_whatever_the_rig(
    parameters: RigParameters, voltages: list[float], start: float
) -> None:
    """Within 5 µm of the run with a hundredth of the tolerance."""
    coarse, fine = (run(parameters, voltages, start, tolerance) for tolerance in (1.0, 0.01))
    assert np.abs(coarse.position - fine.position).max() < 5e-6


@pytest.mark.slow
def test_the_rigs_differ_and_move() -> None:
    """The examples are no one rig: they reach from end to end of ranges, and some move."""
    found: list[tuple[RigParameters, float]] = []

    @settings(FEW, max_examples=200)
    @given(rigs(), VOLTAGES, st.floats(0.0, 1.0))
    def collect(parameters: RigParameters, voltages: list[float], start: float) -> None:
        found.append((parameters, float(np.ptp(run(parameters, voltages, start, 1.0).position))))

    collect()
    bores = [parameters.number("cylinder.bore") for parameters, _ in found]
    assert max(bores) > 0.05
    assert min(bores) < 0.01
    assert {parameters.text("valve.assembly") for parameters, _ in found} == {
        "printed",
        "reconciled",
    }
    assert any(travel > 1e-4 for _, travel in found)
