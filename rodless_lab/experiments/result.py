# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What every experiment hands over: numbers beside the paper's, pictures, and remarks."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from matplotlib.figure import Figure


@dataclass(frozen=True)
class Limits:
    """Bounds (inclusive) that a reproduced number must keep, in its unit, and why these."""

    lowest: float
    highest: float
    why: str


@dataclass(frozen=True)
class Comparison:
    """A reproduced number, in ``unit``, beside what the paper reports for it.

    ``paper`` is text, because most of the paper's findings are figures or words. Without
    ``limits`` the number is shown and not judged.
    """

    quantity: str
    value: float
    unit: str
    paper: str
    limits: Limits | None = None
    decimals: int = 2

    @property
    def holds(self) -> bool:
        """Whether the number keeps its limits; one that is not a number keeps none."""
        return self.limits is None or self.limits.lowest <= self.value <= self.limits.highest


@dataclass(frozen=True)
class Picture:
    """A figure that is drawn when asked for; ``name`` becomes its file's stem."""

    name: str
    caption: str
    draw: Callable[[], Figure]


class Result(Protocol):
    """What the report needs of an experiment's result, whatever arrays it carries."""

    @property
    def comparisons(self) -> tuple[Comparison, ...]:
        """Reproduced numbers beside the paper's."""

    @property
    def pictures(self) -> tuple[Picture, ...]:
        """Figures with axes and units."""

    @property
    def remarks(self) -> tuple[str, ...]:
        """What a reader must know to judge the numbers, in sentences."""


def within(value: float, share: float, why: str) -> Limits:
    """Return limits of ``share`` (such as 0.02) of ``value`` to either side."""
    margin = abs(value) * share
    return Limits(value - margin, value + margin, why)
