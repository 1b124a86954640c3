# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Designs of experiments: which values a study gives to what it varies.

A :class:`Dimension` is one axis of a study: it turns a share of the axis, from 0 to 1, into values
of one parameter or several. A design is shares, shape (rows, dimensions): random, Latin hypercube
or Sobol (``scipy.stats.qmc``).
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import lru_cache
from numbers import Integral
from typing import Protocol, TypeGuard

import numpy as np
import numpy.typing as npt
from scipy.stats import qmc

from rodless_base.one_line import OneLineError, shown
from rodless_base.parameters import ParameterSet, Value
from rodless_base.real_number import is_number

Array = npt.NDArray[np.float64]

# More would take months, and gigabytes before the first run.
MOST_ROWS = 10_000_000
LARGEST_SEED = 2**31 - 1  # as that of sensors.seed

METHODS = ("random", "latin_hypercube", "sobol")


class DesignError(OneLineError):
    """A design that cannot be; the text names value, cause and way out."""


class Axis(Protocol):
    """What varies along one dimension."""

    def at(self, share: float) -> object:
        """Return the value at a share of the axis, from 0 to 1."""

    def levels(self) -> Sequence[object]:
        """Return the values that a grid takes."""


def is_whole(value: object) -> TypeGuard[int]:
    """Whether ``value`` is a whole number, of numpy too."""
    return isinstance(value, Integral) and is_number(value)


def _is_number(value: object) -> bool:
    try:
        return is_number(value) and math.isfinite(value)
    except OverflowError:  # a whole number too large for a float
        return False


@dataclass(frozen=True)
class Range:
    """Numbers from ``low`` to ``high``, even in the value or in its logarithm.

    A grid takes ``count`` of them, both ends among them.
    """

    low: float
    high: float
    count: int = 0
    logarithmic: bool = False

    def __post_init__(self) -> None:
        if not (_is_number(self.low) and _is_number(self.high) and self.low < self.high):
            raise DesignError(
                f"from {shown(self.low)} to {shown(self.high)} refused: must be two finite "
                "numbers, the smaller one first"
            )
        if not isinstance(self.logarithmic, bool):
            raise DesignError(
                f"logarithmic {shown(self.logarithmic)} refused: must be True or False"
            )
        if self.logarithmic and self.low <= 0.0:
            raise DesignError(f"from {self.low:g} refused: a logarithmic range begins above 0")
        if not is_whole(self.count) or not 0 <= self.count <= MOST_ROWS:
            raise DesignError(
                f"count {shown(self.count)} refused: must be a whole number from 0 to {MOST_ROWS}"
            )

    def at(self, share: float) -> float:
        """Return the number at a share of the range."""
        if self.logarithmic:
            found = float(self.low * (self.high / self.low) ** share)
        else:
            found = self.low + share * (self.high - self.low)
        return min(max(found, self.low), self.high) if share < 1.0 else self.high

    def share(self, value: float) -> float:
        """Return where in the range a value is, from 0 to 1; the nearer end for one outside."""
        inside = min(max(value, self.low), self.high)
        if self.logarithmic:
            found = math.log(inside / self.low) / math.log(self.high / self.low)
        else:
            found = (inside - self.low) / (self.high - self.low)
        return min(max(found, 0.0), 1.0)

    def levels(self) -> Sequence[float]:
        """Return ``count`` numbers, both ends among them."""
        if self.count < 2:
            raise DesignError(
                f"from {self.low:g} to {self.high:g} refused: a grid needs its count, 2 or more"
            )
        inner = [self.at(k / (self.count - 1)) for k in range(1, self.count - 1)]
        return [self.low, *inner, self.high]


@dataclass(frozen=True)
class Choice:
    """One of a few values."""

    values: tuple[object, ...]

    def __post_init__(self) -> None:
        if not self.values:
            raise DesignError("no values to choose from: give one or more")

    def at(self, share: float) -> object:
        """Return the value at a share of the list."""
        return self.values[min(int(share * len(self.values)), len(self.values) - 1)]

    def levels(self) -> Sequence[object]:
        """Return all values."""
        return self.values


@dataclass(frozen=True)
class Dimension:
    """One axis of a study, by what it varies: a parameter, or a pattern of several (``*``).

    With ``factor`` the axis holds factors, by which what is varied is multiplied.
    """

    name: str
    axis: Axis
    factor: bool = False

    def names(self, declared: Iterable[str]) -> list[str]:
        """Return the parameters that the axis varies, none where it is for another set."""
        return list(_matching(self.name, tuple(declared)))

    def values(self, base: Mapping[str, Value], level: object) -> dict[str, object]:
        """Return what becomes of the parameters of ``base`` at one value of the axis."""
        names = [self.name] if self.name in base else self.names(base)
        if not self.factor:
            return dict.fromkeys(names, level)
        return {name: scaled(name, base[name], level) for name in names}


@lru_cache  # a study asks for each of its rows
def _matching(pattern: str, declared: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(name for name in declared if fnmatchcase(name, pattern))


def scaled(name: str, value: Value, factor: object) -> object:
    """Return a parameter times a factor; raises DesignError where either is no number."""
    if isinstance(value, tuple):
        return tuple(scaled(name, one, factor) for one in value)
    numbers = (value, factor)
    if not all(map(_is_number, numbers)):
        raise DesignError(f"{name}: {shown(value)} times {shown(factor)} refused: no numbers")
    return float(value) * float(factor)  # type: ignore[arg-type]


def shares(method: str, rows: int, dimensions: int, seed: int) -> Array:
    """Return a design, shape (rows, dimensions), numbers from 0 to 1; the same for one seed.

    The first rows of a random or Sobol design are those of a longer one. Raises DesignError for a
    method that is none of METHODS.
    """
    if not isinstance(method, str) or method not in METHODS:
        raise DesignError(f"method {shown(method)} refused: must be {', '.join(METHODS)}")
    if not is_whole(rows) or not 1 <= rows <= MOST_ROWS:
        raise DesignError(
            f"count {shown(rows)} refused: must be a whole number from 1 to {MOST_ROWS}"
        )
    if not is_whole(seed) or not 0 <= seed <= LARGEST_SEED:
        raise DesignError(
            f"seed {shown(seed)} refused: must be a whole number from 0 to {LARGEST_SEED}"
        )
    if dimensions == 0:
        return np.empty((rows, 0))
    generator = np.random.default_rng(seed)
    if method == "random":
        return generator.random((rows, dimensions))
    if method == "latin_hypercube":
        return np.asarray(qmc.LatinHypercube(dimensions, seed=generator).random(rows))
    engine = qmc.Sobol(dimensions, seed=generator)
    # A Sobol sequence is balanced at powers of two only, and says so.
    exponent = int(max(rows - 1, 1)).bit_length()  # numpy's whole numbers have none
    return np.asarray(engine.random_base2(exponent)[:rows])


def seed_of(seed: int, row: int) -> int:
    """Return the ``sensors.seed`` of one row of a study, drawn from its 2^31.

    Of 100 000 rows a pair or two have the same.
    """
    (word,) = np.random.SeedSequence([seed, row]).generate_state(1)
    return int(word) >> 1


def dimension(name: str, given: object, factor: bool = False) -> Dimension:
    """Return the axis that ``given`` means: (low, high), a list of values, or an axis."""
    if not isinstance(name, str):
        raise DesignError(f"{shown(name)}: no such parameter; names are texts")
    if isinstance(given, Range | Choice):
        return Dimension(name, given, factor)
    with named(name):
        if isinstance(given, tuple) and len(given) == 2:
            return Dimension(name, Range(*given), factor)
        if isinstance(given, list):
            return Dimension(name, Choice(tuple(given)), factor)
    raise DesignError(
        f"{name}: {shown(given)} refused: must be (low, high), a list of values, Range or Choice"
    )


@contextmanager
def named(name: str) -> Iterator[None]:
    """Refuse what is refused of an axis by the name of its parameter."""
    try:
        yield
    except DesignError as error:
        raise DesignError(f"{name}: {error}") from error


def varied(
    base: ParameterSet, dimensions: Sequence[Dimension], row: Sequence[float]
) -> dict[str, object]:
    """Return what one row of a design gives to the parameters of ``base``."""
    found: dict[str, object] = {}
    for one, share in zip(dimensions, row, strict=True):
        found.update(one.values(base, one.axis.at(float(share))))
    return found
