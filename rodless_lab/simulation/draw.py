# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Random rigs around a preset."""

from collections.abc import Iterator, Mapping, Sequence

from rodless_base.one_line import shown
from rodless_lab.simulation.design import DesignError, Dimension, dimension, seed_of, shares, varied
from rodless_sim import RigParameters
from rodless_sim.rig import rig_parameters


def draw(
    ranges: Mapping[str, object],
    count: int,
    base: RigParameters | None = None,
    seed: int = 1,
    method: str = "random",
    factors: Mapping[str, object] | None = None,
) -> Iterator[RigParameters]:
    """Yield ``count`` rigs with values drawn from ``ranges``, each with its own ``sensors.seed``.

    Parameters
    ----------
    ranges
        By parameter, or by a pattern of several that get one value (``friction.*.static``):
        ``(low, high)`` in its unit, ``Range(low, high, logarithmic=True)``, or a list of values.
    count
        How many rigs.
    base
        What the other parameters have; by default the preset ``calibrated``.
    seed
        Of the draw: the same rigs each time.
    method
        ``random``, ``latin_hypercube`` or ``sobol`` (scipy.stats.qmc). The first of many random or
        Sobol rigs are those of a shorter draw.
    factors
        As ``ranges``, of numbers by which the values of ``base`` are multiplied: with
        ``{"friction.*.static": (0.7, 1.3)}`` all static frictions change together.

    Raises
    ------
    DesignError
        A ValueError, at the first rig, for a range, method or count that cannot be, and for a name
        that is no parameter of a rig.
    ParameterError
        At the first rig that cannot be.
    TypeError
        For a base that is no :class:`~rodless_sim.RigParameters`.

    Examples
    --------
    >>> rigs = list(draw({"cylinder.moving_mass": (0.7, 2.0)}, count=3))
    >>> all(0.7 <= rig["cylinder.moving_mass"] <= 2.0 for rig in rigs)
    True
    >>> len({rig["sensors.seed"] for rig in rigs})
    3
    """
    around = RigParameters.preset("calibrated") if base is None else rig_parameters(base)
    dimensions = [
        *_dimensions(ranges, False),
        *_dimensions({} if factors is None else factors, True),
    ]
    _refuse_two_of_one(dimensions)
    for row, design in enumerate(shares(method, count, len(dimensions), seed)):
        values = varied(around, dimensions, design.tolist())
        yield around.with_values({"sensors.seed": seed_of(seed, row), **values})


def _dimensions(given: Mapping[str, object], factor: bool) -> list[Dimension]:
    if not isinstance(given, Mapping):
        raise DesignError(
            f"{shown(given)} refused: must be ranges by name, {{'name': (low, high)}}"
        )
    found = [dimension(name, values, factor) for name, values in given.items()]
    for one in found:
        if not one.names(RigParameters.DECLARATIONS):
            raise DesignError(RigParameters.unknown(one.name))
    return found


def _refuse_two_of_one(dimensions: Sequence[Dimension]) -> None:
    """Raise DesignError where a parameter is drawn twice: one of the two would be lost."""
    owners: dict[str, str] = {}
    for one in dimensions:
        for name in one.names(RigParameters.DECLARATIONS):
            if name in owners:
                raise DesignError(f"{name}: drawn by {owners[name]} and by {one.name}; keep one")
            owners[name] = one.name
