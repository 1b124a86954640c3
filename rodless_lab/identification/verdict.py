# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.
"""Whether a model fits: residuals against what the stated sensors leave, over several spans."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy import linalg, stats

Array = npt.NDArray[np.float64]

# A model that is right is refused once in so many identifications, all checks together.
FALSE_ALARM = 0.01

MISFIT = "the model does not fit"

# A sensor's bias that is found so many of its standard errors beyond what is stated is no chance;
# and what is to be done then.
BEYOND_STATED = 4.0
ZEROED = "sensors that are zeroed against each other, or their sensors.pressure_bias in the base"


@dataclass(frozen=True)
class Check:
    """One test of the residuals: what they show, what a model that fits leaves, both in ``unit``.

    ``p_value`` is the probability that a model that fits shows as much or more.
    """

    name: str
    found: float
    expected: float
    unit: str
    p_value: float

    def __str__(self) -> str:
        unit = f" {self.unit}" if self.unit else ""
        return f"{self.name} {self.found:.3g}{unit}, explained {self.expected:.3g}{unit}"


@dataclass(frozen=True)
class Verdict:
    """What several checks say together; ``cause`` is what the model likely lacks.

    Examples
    --------
    >>> good = Check("scatter", 204.0, 203.0, "Pa", 0.4)
    >>> bad = Check("scatter", 304.0, 203.0, "Pa", 1e-9)
    >>> Verdict((good,)).fits, str(Verdict((good, bad), "heat"))
    (True, 'the model does not fit: scatter 304 Pa, explained 203 Pa; likely missing: heat')
    """

    checks: tuple[Check, ...]
    cause: str = ""

    @property
    def p_value(self) -> float:
        """The smallest of all checks, times their number (Bonferroni); 1 without any."""
        smallest = min((check.p_value for check in self.checks), default=1.0)
        return min(smallest * max(len(self.checks), 1), 1.0)

    @property
    def fits(self) -> bool:
        """Whether the residuals are what a model that fits leaves."""
        return self.p_value >= FALSE_ALARM

    def blaming(self, cause: str) -> "Verdict":
        """Return the verdict with its likely cause."""
        return replace(self, cause=cause)

    def __str__(self) -> str:
        if self.fits:
            return f"the residuals are what the stated sensors explain (p = {self.p_value:.2g})"
        worst = min(self.checks, key=lambda check: (check.p_value, -check.found / check.expected))
        cause = f"; likely missing: {self.cause}" if self.cause else ""
        return f"{MISFIT}: {worst}{cause}"


def joined(verdicts: Sequence[Verdict]) -> Verdict:
    """Return the verdict of all checks of several."""
    causes = dict.fromkeys(verdict.cause for verdict in verdicts if verdict.cause)
    checks = tuple(check for verdict in verdicts for check in verdict.checks)
    return Verdict(checks, "; ".join(causes))


def blocks(values: Array, length: int) -> Array:
    """Return blocks of ``length`` along a further, last axis; what fills none is left out."""
    count = values.shape[-1] // length
    return values[..., : count * length].reshape(*values.shape[:-1], count, length)


def power(residuals: Array, length: int) -> Array:
    """Mean square of the means over blocks of ``length`` samples, along the last axis.

    White residuals of variance 1 have 1/length; what is correlated over a block shows in full.
    """
    return np.asarray(np.mean(np.mean(blocks(residuals, length), axis=-1) ** 2, axis=-1))


def tail(found: float, explained: Array) -> float:
    """Probability of ``found`` or more, of which ``explained``, shape (k,), are random draws.

    A sum of squares of Gaussian numbers is close to a scaled chi-square of the same mean and
    variance (Satterthwaite 1946): that reaches further into the tail than the draws themselves.
    """
    mean, variance = float(np.mean(explained)), float(np.var(explained, ddof=1))
    if mean <= 0.0 or variance <= 0.0:
        return 1.0 if found <= mean else 0.0
    freedom = 2.0 * mean**2 / variance
    return float(stats.chi2.sf(found * freedom / mean, freedom))


def check_power(name: str, found: float, explained: Array, unit: str, scale: float) -> Check:
    """Compare a mean square with draws of it; the check shows roots times ``scale`` in ``unit``."""
    return Check(
        name,
        scale * math.sqrt(found),
        scale * math.sqrt(float(np.mean(explained))),
        unit,
        tail(found, explained),
    )


# Spans (s) over which residuals are averaged before they are squared: 0 is each by itself, which
# tells their size; the others what is slower, and hides in the noise of a single reading.
SPANS = (0.0, 0.01, 0.1)


def span_checks(
    compared: Sequence[tuple[str, Array, Array]], spacing: float, unit: str, scale: float
) -> Iterator[Check]:
    """Yield, for each of SPANS, what residuals show beside draws of what a right model leaves.

    ``compared`` has the name of each, its residuals, shape (..., m), and draws of them, shape
    (d, ..., m), ``spacing`` s apart. The checks show roots times ``scale`` in ``unit``.
    """
    samples = compared[0][1].shape[-1]
    for span in SPANS:
        length = max(round(span / spacing), 1)
        if 2 * length > samples:
            continue
        over = f" over {span:g} s" if span else ""
        for name, found, drawn in compared:
            expected = power(drawn, length).reshape(len(drawn), -1).mean(axis=1)
            mean = float(np.mean(power(found, length)))
            yield check_power(f"{name}{over}", mean, expected, unit, scale)


# Draws of what chance leaves, their seed, and how many neighbours go together.
DRAWS = 400
SEED = 1
NEIGHBOURS = 4

# Residuals smaller than this share of what was measured are rounding.
ROUNDING = 1e-9


def whiteness(residuals: Array, jacobian: Array, size: float) -> Verdict:
    """Say whether residuals, shape (n,), in the order of what was varied, are without a pattern.

    For a fit of which the measurement's error is not known: neighbours that stray to one side
    together are a curve of another shape. ``jacobian``, shape (n, p), is that of the fit, ``size``
    that of what was measured: what rounding leaves of it has patterns and says nothing.
    """
    if len(residuals) < 2 * NEIGHBOURS or float(np.std(residuals)) <= ROUNDING * abs(size):
        return Verdict(())
    directions, sizes, _ = linalg.svd(jacobian, full_matrices=False)
    seen = directions[:, sizes > 1e-10 * sizes[0]]
    drawn = np.random.default_rng(SEED).standard_normal((DRAWS, len(residuals)))
    drawn -= drawn @ seen @ seen.T
    found, explained = _alike(residuals), _alike(drawn)
    check = check_power("scatter of neighbours", float(found), explained, "of the scatter", 1.0)
    return Verdict((check,))


def _alike(residuals: Array) -> Array:
    """Mean square of the means of neighbours, over the residuals' own."""
    return power(residuals, NEIGHBOURS) / power(residuals, 1)
