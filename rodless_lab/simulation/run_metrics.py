# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A run of the rig in figures: what an ensemble keeps of each.

With the error e = r - y of the carriage's true position y from the reference r, all of it about the
run from ``since`` on, or about its last second:

    final error     e at the last sample
    mean error      mean of e over the last second
    limit cycle     (max e - min e)/2 over the last second
    settling        from where r last begins to move until |e| <= 0.2 mm for good
    overshoot       how far y passes the last r, in the direction of the last motion of r, counted
                    from where r turned that way; in that of the carriage's way there if it was past
                    the last r then, or r has always been the same; 0 if that began within 0.2 mm
    peak, RMS       max |e|, sqrt(mean e^2)
    air             what has flowed into both chambers, by the flows at the samples
    valve travel    sum of |u[k+1] - u[k]|
    rest, chatter   of u in the last second: RMS about its mean; RMS of u[k+1] - u[k]
"""

import math
from typing import Annotated, NamedTuple

import numpy as np
import numpy.typing as npt

from rodless_base.kernels import outlined_kernel
from rodless_base.one_line import shown
from rodless_lab.simulation.closed_loop import ClosedLoopTrace
from rodless_sim.single_number import single_number

Array = npt.NDArray[np.float64]

# The paper's positioning tolerance (section 7): 0.2 mm.
SETTLING_BAND = 2e-4  # m

# What a reference that was computed (m) may be off, which is no motion.
ROUNDING = 1e-9

# What is said of the rest is said of this long at the end, or of a shorter run.
LAST = 1.0  # s


class RunMetrics(NamedTuple):
    """Figures of one run in closed loop; NaN for what it does not have.

    The settling time is NaN where the carriage has not settled, and so are settling time and
    overshoot where the reference still moves at the end.
    """

    final_error: Annotated[float, "m", "reference less position at the end"]
    mean_error: Annotated[float, "m", "mean error of the last second"]
    settling_time: Annotated[float, "s", "from where the reference last begins to move to ±0.2 mm"]
    overshoot: Annotated[float, "m", "past the last reference"]
    peak_error: Annotated[float, "m", "largest error"]
    rms_error: Annotated[float, "m", "root mean square of the error"]
    limit_cycle: Annotated[float, "m", "amplitude of the error in the last second"]
    air: Annotated[float, "kg", "air that has flowed into the chambers"]
    valve_travel: Annotated[float, "V", "sum of the changes of the command"]
    rest_voltage: Annotated[float, "V", "RMS of the command about its mean in the last second"]
    chatter: Annotated[float, "V", "RMS of the command's changes in the last second"]


NO_METRICS = RunMetrics(*(math.nan,) * len(RunMetrics._fields))


def run_metrics(run: ClosedLoopTrace, since: float = 0.0) -> RunMetrics:
    """Return the figures of a run.

    Parameters
    ----------
    run
        From :func:`rodless_lab.closed_loop`.
    since
        When peak and RMS begin to count, in s: a sine after its first period, for example.

    Raises
    ------
    ValueError
        For a ``since`` that is before the run or after it.
    TypeError
        For a ``run`` that is none, or a ``since`` that is no number.

    Examples
    --------
    >>> from rodless_control import PidParameters, references
    >>> from rodless_lab import closed_loop
    >>> from rodless_sim import RigParameters
    >>> step = references.step(0.0, 0.058, at=0.5)
    >>> run = closed_loop(RigParameters(), PidParameters(), step, duration=4.0, period=1e-3)
    >>> run_metrics(run).settling_time < 2.0
    True
    """
    if not isinstance(run, ClosedLoopTrace):
        raise TypeError(f"{shown(run)} refused, must be a run of rodless_lab.closed_loop")
    return metrics_of(
        run.time,
        run.reference,
        np.column_stack([run.mass_flow_a, run.mass_flow_b]),
        0,
        np.column_stack([run.voltage, run.true_position]),
        since,
    )


def metrics_of(
    times: Array, reference: Array, rows: Array, flows: int, commands: Array, since: float
) -> RunMetrics:
    """Return the figures of a run whose columns stand in arrays of more, each of n rows.

    From column ``flows`` on, ``rows`` has the mass flows into both chambers (kg/s); ``commands``
    begins with the voltage (V) and ends with the true position (m). Raises as :func:`run_metrics`.
    """
    begin = single_number(since, "since", "seconds")
    if not times[0] <= begin <= times[-1]:
        raise ValueError(
            f"since {begin:g} s refused: the run is from {times[0]:g} to {times[-1]:g} s"
        )
    period = float(times[1] - times[0])
    first = int(np.searchsorted(times, begin))
    last = min(round(LAST / period), len(times) - 1) + 1
    return RunMetrics(*measured(reference, rows, flows, commands, period, first, last))


@outlined_kernel
def measured(
    reference: Array,
    rows: Array,
    flows: int,
    commands: Array,
    period: float,
    first: int,
    last: int,
) -> tuple[float, float, float, float, float, float, float, float, float, float, float]:
    """Return the fields of :class:`RunMetrics` for arrays as :func:`metrics_of` takes them.

    Samples are ``period`` s apart. Peak and RMS begin at sample ``first``; the ``last`` ones are
    those of the last second.
    """
    voltage, position = commands[:, 0], commands[:, commands.shape[1] - 1]
    flow_a, flow_b = rows[:, flows], rows[:, flows + 1]
    count = reference.size
    peak, squares = 0.0, 0.0
    for k in range(first, count):
        error = reference[k] - position[k]
        peak = max(peak, abs(error))
        squares += error * error
    air, travel = 0.0, 0.0
    for k in range(count - 1):
        air += period * (max(flow_a[k], 0.0) + max(flow_b[k], 0.0))
        travel += abs(voltage[k + 1] - voltage[k])
    lowest, highest, errors, volts, changes = math.inf, -math.inf, 0.0, 0.0, 0.0
    for k in range(count - last, count):
        error = reference[k] - position[k]
        lowest, highest = min(lowest, error), max(highest, error)
        errors += error
        volts += voltage[k]
        if k + 1 < count:
            changes += (voltage[k + 1] - voltage[k]) ** 2
    spread = 0.0
    for k in range(count - last, count):
        spread += (voltage[k] - volts / last) ** 2
    settling, overshoot = settled(reference, position, period)
    return (
        reference[-1] - position[-1],
        errors / last,
        settling,
        overshoot,
        peak,
        math.sqrt(squares / (count - first)),
        0.5 * (highest - lowest),
        air,
        travel,
        math.sqrt(spread / last),
        math.sqrt(changes / max(last - 1, 1)),
    )


@outlined_kernel
def settled(reference: Array, position: Array, period: float) -> tuple[float, float]:
    """Return settling time (s) and overshoot (m) of the last motion of the reference."""
    count = reference.size
    end = count - 1
    while end > 0 and reference[end] == reference[end - 1]:
        end -= 1
    if end == count - 1:
        return math.nan, math.nan
    # The reference rests from ``end`` on, and has moved without a rest since ``start``.
    start = end
    # Two equal samples on the way are no rest: a sine has them about a crest.
    while start > 1 and not (
        reference[start - 1] == reference[start - 2]
        and (start == 2 or reference[start - 2] == reference[start - 3])
    ):
        start -= 1
    if start < end == count - 2:
        return math.nan, math.nan
    turn, direction = _last_way(reference, position, max(start - 1, 0), end)
    beyond = 0.0
    for k in range(turn + 1, count):
        beyond = max(beyond, direction * (position[k] - reference[-1]))
    inside = count
    while inside > start and abs(reference[inside - 1] - position[inside - 1]) <= SETTLING_BAND:
        inside -= 1
    if inside == count:
        return math.nan, beyond
    return (inside - start) * period, beyond


@outlined_kernel
def _last_way(reference: Array, position: Array, first: int, end: int) -> tuple[int, float]:
    """Return the sample from which the reference went straight to where it is at ``end``, and how.

    1.0 for upwards, -1.0 for downwards, 0.0 for a carriage that was there. Nothing before sample
    ``first`` counts.
    """
    target = reference[end]
    k = end
    while k > first and abs(reference[k] - target) <= ROUNDING:
        k -= 1
    turn, direction = k, 0.0
    if abs(reference[k] - target) > ROUNDING:
        direction = math.copysign(1.0, target - reference[k])
        while k > first and direction * (reference[k - 1] - reference[turn]) <= ROUNDING:
            k -= 1
            if direction * (reference[k] - reference[turn]) < 0.0:
                turn = k
    # A carriage that is past the target already comes from the other side.
    past = position[turn] - target
    if (direction * past if direction != 0.0 else abs(past)) > SETTLING_BAND:
        direction = -math.copysign(1.0, past)
    return turn, direction
