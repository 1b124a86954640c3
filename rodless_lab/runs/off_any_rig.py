# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Readings that no rig has, and what they may come from."""

import numpy as np
import numpy.typing as npt

from rodless_base.constants import MAXIMUM_VOLTAGE, MINIMUM_VOLTAGE
from rodless_base.topics import JOINT_STATES, PRESSURES, VALVE_STATE, VALVE_VOLTAGE
from rodless_control.parameters import REFERENCE
from rodless_lab.runs.measured_run import MeasuredRun

# Within these (m) a controller can be asked to hold a carriage, of however long a cylinder.
LIMITS = REFERENCE["reference.minimum"].minimum, REFERENCE["reference.maximum"].maximum

# m/s: the series is made for 0.5, and the noise of an instrument (10 um, each 0.1 ms) makes 0.1.
FASTEST = 20.0

# Pa absolute: a third of what there is on the highest mountains, and twice what valve and cylinder
# are made for.
LEAST_PRESSURE = 1e4
LARGEST_PRESSURE = 2e6

# V, by which a converter may miss the ends of its range.
WITHIN = 0.1


def off_any_rig(run: MeasuredRun) -> list[str]:
    """Say which readings of a run no rig can have, and why it may have them; one line for each."""
    found = (_beyond(run) or _too_fast(run), _no_command(run), _no_pressure(run))
    return list(filter(None, found))


def _beyond(run: MeasuredRun) -> str:
    low, high = LIMITS
    place = _first((run.position < low) | (run.position > high))
    if place is None:
        return ""
    return (
        f"{JOINT_STATES}: positions leave {low:g} to {high:g} m, at {run.time[place]:.3f} s with "
        f"{run.position[place]:.6g} m; they must be in m, and may be in mm"
    )


def _too_fast(run: MeasuredRun) -> str:
    steps = np.abs(np.diff(run.position))
    place = _first(steps > FASTEST * run.period)
    if place is None:
        return ""
    return (
        f"{JOINT_STATES}: the position jumps by {steps[place]:.3g} m within {run.period:.3g} s, "
        f"at {run.time[place + 1]:.3f} s, as no carriage does; several plants of one name may have "
        "sent, or the instrument failed"
    )


def _no_command(run: MeasuredRun) -> str:
    low, high = MINIMUM_VOLTAGE, MAXIMUM_VOLTAGE
    place = _first((run.voltage < low - WITHIN) | (run.voltage > high + WITHIN))
    if place is None:
        return ""
    topic = VALVE_VOLTAGE if run.commanded else VALVE_STATE
    return (
        f"{topic}: voltages leave {low:g} to {high:g} V, at {run.time[place]:.3f} s with "
        f"{run.voltage[place]:.6g} V; they must be in V, and a replay holds them to that range"
    )


def _no_pressure(run: MeasuredRun) -> str:
    for name, topic in PRESSURES.items():
        pressure = getattr(run, name)
        place = _first((pressure < LEAST_PRESSURE) | (pressure > LARGEST_PRESSURE))
        if place is not None:
            return (
                f"{topic}: {pressure[place]:.6g} Pa at {run.time[place]:.3f} s is outside "
                f"{LEAST_PRESSURE:g} to {LARGEST_PRESSURE:g} Pa, as in no rig; pressures must be "
                "absolute and in Pa, and may be gauge, or in kPa or bar"
            )
    return ""


def _first(odd: npt.NDArray[np.bool_]) -> int | None:
    places = np.flatnonzero(odd)
    return int(places[0]) if len(places) else None
