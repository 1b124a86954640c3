# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Breakaways and stops of a slowly forced carriage: the forces uniform motion cannot show."""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rodless_base.number_rows import LARGEST, number_rows
from rodless_lab.identification.friction.uniform_motion import position_noise
from rodless_lab.runs.measured_run import even_period
from rodless_sim.single_number import single_number

Array = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

# Length in s of the line by which motion is told from rest.
LINE = 0.06

# A stick or a slip shorter than this (s) is too short to fit the force on either side of an event.
SHORTEST = 0.08

# Stretch in s before and after an event over which the force is fitted, and the part next to
# the event left out: position tells its moment no better, and the sensor's lag blurs it.
REACH = 0.25
CLEARANCE = 0.025

# Faster than this (N/s) the force changes too much between the event and its effect to be read.
FASTEST_FORCE = 100.0

# No event is known better than this (N).
FINEST = 0.04


@dataclass(frozen=True)
class StickSlipEvents:
    """Forces in N, signed like the motion, with standard errors; times in s. Shapes (k,), (l,).

    ``breakaways`` are maxima of the force where the carriage lets go, ``stops`` its minima where
    it catches again.
    """

    breakaways: Array
    breakaway_errors: Array
    breakaway_times: Array
    stops: Array
    stop_errors: Array
    stop_times: Array


@dataclass(frozen=True)
class _Event:
    time: float
    force: float
    error: float


def stick_slip_events(
    time: Array, position: Array, force: Array, lag: float = 0.0
) -> StickSlipEvents:
    """Find where a slowly rising force lets the carriage go and a falling one catches it.

    On either side of an event the force is smooth: a curve is fitted to each, and their crossing is
    the event. Left out are events at which the force does not turn (a creep that just begins or
    ends), or turns too fast.

    Parameters
    ----------
    time, position, force
        Shape (n,): s, evenly spaced, m, and N (A (P_a - P_b)).
    lag
        Time constant of the pressure sensors in s, which is taken out.

    Raises
    ------
    ValueError
        For what is no even run of numbers (``RunError``, or with the name of the argument), and for
        a lag that is no number from 0 on.

    Examples
    --------
    >>> from rodless_sim import RigParameters, simulate
    >>> rig = RigParameters({"supply.pressure": 601325.0})
    >>> run = simulate(rig, [5.26] * 8000, 1e-3, position=0.02)
    >>> events = stick_slip_events(run.time, run.position, run.force)
    >>> round(float(events.stops.mean()), 1)  # the minimum of the curve, 22.56 N
    22.5
    """
    columns = {"time": time, "position": position, "force": force}
    time, position, force = number_rows(columns)
    period = even_period(time)
    lag = single_number(lag, "lag", "seconds")
    if not 0.0 <= lag <= LARGEST:
        raise ValueError(f"lag {lag:g} s refused: must be from 0 to {LARGEST:g}")
    motion = direction_of_motion(time, position)
    changes = np.flatnonzero(np.diff(motion)) + 1
    edges = np.concatenate([[0], changes, [len(motion)]])
    shortest = round(SHORTEST / period)
    breakaways: list[_Event] = []
    stops: list[_Event] = []
    for before, at, after in zip(edges[:-2], edges[1:-1], edges[2:], strict=True):
        if at - before < shortest or after - at < shortest:
            continue
        released, caught = motion[at] != 0, motion[at - 1] != 0
        if released == caught:
            continue
        sign = int(motion[at] if released else motion[at - 1])
        event = _turn(time, sign * force, (int(before), int(at), int(after)), released, lag)
        if event is not None:
            signed = _Event(event.time, sign * event.force, event.error)
            (breakaways if released else stops).append(signed)
    return StickSlipEvents(*_columns(breakaways), *_columns(stops))


def _columns(events: list[_Event]) -> tuple[Array, Array, Array]:
    return (
        np.array([event.force for event in events]),
        np.array([event.error for event in events]),
        np.array([event.time for event in events]),
    )


def direction_of_motion(time: Array, position: Array) -> npt.NDArray[np.int64]:
    """+1, -1 or 0 for each sample: by the slope of short lines, against its own error."""
    period = float(time[-1] - time[0]) / (len(time) - 1)
    half = max(round(0.5 * LINE / period), 1)
    offsets = np.arange(-half, half + 1) * period
    weights = offsets / np.sum(offsets**2)
    padded = np.pad(position, half, mode="edge")
    speed = np.correlate(padded, weights, mode="valid")
    error = position_noise(position) / math.sqrt(float(np.sum(offsets**2)))
    # Two thresholds, so that noise about a single one does not chop a slip to pieces.
    moving = _hysteresis(np.abs(speed), 2.0 * error + 1e-4, 4.0 * error + 3e-4)
    return np.where(moving, np.sign(speed), 0.0).astype(np.int64)


def _hysteresis(values: Array, low: float, high: float) -> Flags:
    """Stretches above ``low`` that somewhere exceed ``high``."""
    above = values > low
    starts = np.flatnonzero(np.diff(np.concatenate([[False], above])) & above)
    numbers = np.cumsum(np.isin(np.arange(len(values)), starts)) * above
    strong = np.unique(numbers[values > high])
    return np.isin(numbers, strong[strong > 0])


def _turn(
    time: Array, force: Array, edges: tuple[int, int, int], rising: bool, lag: float
) -> _Event | None:
    """Return where the curves through the force before and after sample ``edges[1]`` cross."""
    before, at, after = edges
    moment = float(time[at])
    # The last stretch of the neighbouring event is not part of this one.
    past = _fitted(
        time, force, moment, (max(-REACH, time[before] - moment + CLEARANCE), -CLEARANCE), lag
    )
    ahead = _fitted(
        time, force, moment, (CLEARANCE, min(REACH, time[after - 1] - moment - CLEARANCE)), lag
    )
    if past is None or ahead is None:
        return None
    crossing = _crossing(past[0], ahead[0])
    if crossing is None:
        return None
    slope_before, slope_after = past[0].deriv()(crossing), ahead[0].deriv()(crossing)
    turns = slope_before > 0.0 > slope_after if rising else slope_before < 0.0 < slope_after
    if not turns or max(abs(slope_before), abs(slope_after)) > FASTEST_FORCE:
        return None
    error = max(past[1], ahead[1], FINEST)
    return _Event(moment + crossing, float(past[0](crossing)), error)


def _fitted(
    time: Array, force: Array, moment: float, span: tuple[float, float], lag: float
) -> tuple[np.polynomial.Polynomial, float] | None:
    """Parabola of the force over ``span`` (s from the moment), lag removed, and its error there."""
    chosen = (time >= moment + span[0]) & (time <= moment + span[1])
    count = int(np.count_nonzero(chosen))
    if count < 12:
        return None
    local = time[chosen] - moment
    curve = np.polynomial.Polynomial.fit(local, force[chosen], 2)
    scatter = float(np.std(force[chosen] - curve(local), ddof=3))
    # A parabola's end is known three times worse than its mean.
    plain = curve.convert()
    return plain + lag * plain.deriv(), 3.0 * scatter / math.sqrt(count)


def _crossing(before: np.polynomial.Polynomial, after: np.polynomial.Polynomial) -> float | None:
    """Time from the presumed moment at which both curves meet, within what position can miss."""
    reach = 2.0 * CLEARANCE + 0.5 * LINE
    roots = (before - after).roots()
    meetings = [float(root.real) for root in np.atleast_1d(roots) if abs(root.imag) < 1e-9]
    near = [moment for moment in meetings if abs(moment) <= reach]
    return min(near, key=abs) if near else None
