# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A run as instruments saw it, checked before anything is computed from it."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import numpy.typing as npt

from rodless_base.columns import Columns
from rodless_base.one_line import OneLineError, shown
from rodless_sim import Trace

Array = npt.NDArray[np.float64]

# Fewer samples than this are no run.
FEWEST_SAMPLES = 20

# A sample may be off an even grid by this share of the period: stamps are rounded, and timers
# jitter. That does not add up, while one sample that is missing leaves half a period.
TIME_TOLERANCE = 0.3


class RunError(OneLineError):
    """A run that cannot be used; the text says what is wrong and where."""


class UninformativeRunError(RunError):
    """A sound run that says nothing of what is asked; the text says why."""


def even_period(time: Array) -> float:
    """Return the time (s) between samples at ``time`` (s, shape (n,), finite numbers).

    Raises RunError where that does not increase, or unevenly, or has fewer than two samples.
    """
    time = np.asarray(time, dtype=np.float64)
    steps = np.diff(time)
    if not len(steps):
        raise RunError(f"only {len(time)} samples, too few for a run")
    back = np.flatnonzero(steps <= 0.0)
    if len(back):
        raise RunError(f"time does not increase at sample {back[0] + 1}")
    period = _period(time)
    if float(np.max(np.abs(_off_the_line(time - time[0])))) > TIME_TOLERANCE * period:
        usual = float(np.median(steps))
        place = int(np.argmax(np.abs(steps - usual)))
        raise RunError(
            f"time: sample {place + 1} comes {steps[place]:.6g} s after the one before, "
            f"mostly it is {usual:.6g} s; interpolate to an even time base"
        )
    return period


def _off_the_line(time: Array) -> Array:
    """Return ``time`` less the straight line that fits it best, shape (n,)."""
    number = np.arange(len(time)) - 0.5 * (len(time) - 1)
    slope = float(number @ time) / float(number @ number)
    return np.asarray(time - np.mean(time) - slope * number)


def _period(time: Array) -> float:
    return float(time[-1] - time[0]) / (len(time) - 1)


@dataclass(frozen=True)
class MeasuredRun(Columns):
    """Arrays of one shape (n,) on one evenly spaced time base; pressures are absolute.

    ``voltage[k]`` is held from sample k to sample k+1; ``doubt`` says why that is not known sample
    by sample, if so, and ``missing`` which samples the recording lacks, whose values are those of
    their neighbours; ``remarks`` say what else is odd about it, one line each. The voltage is what
    the valve followed, behind its faults; where it is ``commanded``, as in a bag without
    ``valve/state``, it is what was asked of the valve. Saved and made a data frame by
    :class:`~rodless_base.columns.Columns`.

    Examples
    --------
    >>> import numpy as np
    >>> still = np.full(100, 4e5)
    >>> run = MeasuredRun(np.arange(100) * 1e-3, still / 4e6, still, still, still, still / 1e5)
    >>> run.units()["position"]
    'm'
    >>> round(run.period, 6)
    0.001
    """

    time: Annotated[Array, "s"]
    position: Annotated[Array, "m"]
    pressure_a: Annotated[Array, "Pa"]
    pressure_b: Annotated[Array, "Pa"]
    supply_pressure: Annotated[Array, "Pa"]
    voltage: Annotated[Array, "V"]
    doubt: str = ""
    missing: str = ""
    remarks: tuple[str, ...] = ()
    commanded: bool = False

    def __post_init__(self) -> None:
        """Raise :class:`RunError` for a run too short or not finite, and for uneven time.

        And for columns that are no arrays of numbers.
        """
        for name, values in self.columns().items():
            kind = values.dtype.kind if isinstance(values, np.ndarray) else ""
            if not kind or kind not in "fiu" or values.ndim != 1:
                raise RunError(f"{name}: {shown(values)} refused, must be an array of numbers")
            if np.ma.is_masked(values):
                raise RunError(f"{name}: some samples are masked, fill or leave them out")
            # Whole numbers without a sign have no differences below 0; compiled kernels, tables and
            # solvers know no half or long reals, nor those of another machine's byte order.
            if values.dtype not in (np.float32, np.float64):
                object.__setattr__(self, name, values.astype(np.float64))
        if len(self.time) < FEWEST_SAMPLES:
            raise RunError(f"only {len(self.time)} samples, too few for a run")
        for name, values in self.columns().items():
            if values.shape != self.time.shape:
                raise RunError(f"{name} has {len(values)} samples, time {len(self.time)}")
            bad = np.flatnonzero(~np.isfinite(values))
            if len(bad):
                raise RunError(f"{name}: sample {bad[0]} is {values[bad[0]]}")
        even_period(self.time)

    @property
    def period(self) -> float:
        """Time between samples in s."""
        return _period(self.time)

    @property
    def notes(self) -> tuple[str, ...]:
        """What to know of the recording before its numbers are trusted: one line each."""
        return tuple(note for note in (self.doubt, self.missing, *self.remarks) if note)

    def check_voltage(self) -> None:
        """Raise :class:`RunError` where the voltage is not known well enough to repeat the run."""
        if self.doubt:
            raise RunError(self.doubt)


@dataclass(frozen=True)
class Setpoint:
    """Set-points and when each was given, on the time base of the run; shapes (k,).

    ``doubt`` says why it is not known when they were given, if so.
    """

    time: Array  # s
    position: Array  # m
    doubt: str = ""


def run_of_trace(trace: Trace, supply_pressure: float | Array) -> MeasuredRun:
    """Return a trace, true or measured, as a run with these readings of the supply (Pa).

    One number is a constant reading.

    Examples
    --------
    >>> from rodless_sim import RigParameters, simulate
    >>> run = run_of_trace(simulate(RigParameters(), [5.6] * 100, 1e-3), 6e5)
    >>> float(run.supply_pressure.mean())
    600000.0
    """
    return MeasuredRun(
        trace.time,
        trace.position,
        trace.pressure_a,
        trace.pressure_b,
        np.full(trace.time.shape, supply_pressure),
        trace.voltage,
    )
