# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The root of a function between two places, found in compiled code without a call to Python.

Brent's method (Algorithms for Minimization without Derivatives, 1973, chapter 4), step for step as
scipy's ``brentq``, with the same bits. Compiled code takes no functions: whoever looks for a root
asks for the :func:`next_guess`, and says what the function is at the one before.
"""

import math
from typing import NamedTuple

from rodless_base.kernels import kernel

MOST_STEPS = 100  # then scipy gives up, too


class Search(NamedTuple):
    """A root between ``behind`` and ``now``, or ``now`` itself where ``found``."""

    before: float
    now: float
    behind: float
    of_before: float
    of_behind: float
    step_before: float
    step: float
    found: bool


@kernel
def begun(low: float, high: float, of_low: float) -> Search:
    """Begin between two places at which the function has opposite signs, at ``high``."""
    step = high - low
    return Search(low, high, low, of_low, of_low, step, step, False)


@kernel
def next_guess(search: Search, of_now: float, error: float, relative_error: float) -> Search:
    """Put ``now``, where the function is ``of_now``, to the next place, or say that it is the root.

    It is one where the root is no farther than ``error`` and ``relative_error`` of it.
    """
    before, now, behind, of_before, of_behind, step_before, step, _ = search
    if of_before != 0.0 and of_now != 0.0 and (of_before < 0.0) != (of_now < 0.0):
        behind, of_behind = before, of_before
        step_before = step = now - before
    if abs(of_behind) < abs(of_now):
        before, now, behind = now, behind, now
        of_before, of_now, of_behind = of_now, of_behind, of_now
    near = (error + relative_error * abs(now)) / 2.0
    half = (behind - now) / 2.0
    if of_now == 0.0 or abs(half) < near:
        return Search(before, now, behind, of_before, of_behind, step_before, step, True)
    tried = math.inf
    if abs(step_before) > near and abs(of_now) < abs(of_before):
        tried = interpolated(before, now, behind, of_before, of_now, of_behind)
    if 2.0 * abs(tried) < min(abs(step_before), 3.0 * abs(half) - near):
        step_before, step = step, tried
    else:
        step_before = step = half
    there = now + (step if abs(step) > near else math.copysign(near, half))
    return Search(now, there, behind, of_now, of_behind, step_before, step, False)


@kernel
def interpolated(
    before: float, now: float, behind: float, of_before: float, of_now: float, of_behind: float
) -> float:
    """Step from ``now`` to where a line, or with three places a curve, has no height."""
    if before == behind:
        return -of_now * (now - before) / (of_now - of_before)
    slope = (of_before - of_now) / (before - now)
    other = (of_behind - of_now) / (behind - now)
    top = -of_now * (of_behind * other - of_before * slope)
    return top / (other * slope * (of_behind - of_before))
