# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Whether the carriage gives where friction holds it: eq. (29) lets nothing move, bristles do."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import stats

from rodless_lab.identification.friction.stick_slip import Flags, direction_of_motion
from rodless_lab.identification.verdict import Check, Verdict, blocks

Array = npt.NDArray[np.float64]

# Means over blocks of this length (s) are compared: the sensors' lag makes neighbours alike.
BLOCK = 0.05

# Left out (s) at both ends of a rest, whose ends are known no better; and the share of its greatest
# force beyond which eq. (29) lets the carriage creep.
EDGE = 0.1
HELD = 0.9

# Blocks in a rest that say how far position follows force.
FEWEST = 4

# A carriage that gives no more than this (m/N) is too stiff for any reading of friction to show it.
SMALLEST_GIVE = 2e-8


class Give(NamedTuple):
    """How far the carriage moves with the force while friction holds it, and the standard error."""

    compliance: float  # m/N
    error: float  # m/N


def give_at_rest(time: Array, position: Array, force: Array) -> Give | None:
    """Regress position on force over all rests; None where there are none, or no force varies.

    Before it breaks loose, a carriage on bristles of stiffness σ₀ moves by about F/σ₀ (presliding:
    Canudas de Wit, Olsson, Åström, Lischinsky, "A new model for control of systems with friction",
    *IEEE Transactions on Automatic Control* 40(3), 1995, 419-425), one of eq. (29) not at all.

    Parameters
    ----------
    time, position, force
        Shape (n,): s, evenly spaced, m, and N (A (P_a - P_b)).
    """
    period = float(time[-1] - time[0]) / (len(time) - 1)
    length, edge = max(round(BLOCK / period), 1), round(EDGE / period)
    ways, forces = [], []
    for first, last in _rests(direction_of_motion(time, position) == 0):
        if last - first < 2 * edge + FEWEST * length:
            continue
        inside = slice(first + edge, last - edge)
        way, load = (blocks(values[inside], length).mean(axis=1) for values in (position, force))
        held = np.abs(load) < HELD * np.max(np.abs(load))
        if np.count_nonzero(held) >= FEWEST:
            ways.append(way[held] - np.mean(way[held]))
            forces.append(load[held] - np.mean(load[held]))
    power = float(sum(load @ load for load in forces))
    if not power > 0.0:
        return None
    way, load = np.concatenate(ways), np.concatenate(forces)
    compliance = float(way @ load) / power
    left = way - compliance * load
    freedom = len(way) - len(ways) - 1
    return Give(compliance, float(np.sqrt(left @ left / freedom / power)))


def _rests(still: Flags) -> list[tuple[int, int]]:
    """Return the first sample of each stretch of ``still`` ones, and the one behind its last."""
    turns = np.flatnonzero(np.diff(np.concatenate([[False], still, [False]]).astype(int)))
    return [(int(first), int(last)) for first, last in turns.reshape(-1, 2)]


def verdict_of(give: Give | None) -> Verdict:
    """Say whether friction of eq. (29) holds the carriage; without a rest nothing is said."""
    if give is None:
        return Verdict(())
    error = float(np.hypot(give.error, SMALLEST_GIVE))
    p_value = float(stats.norm.sf(give.compliance / error))
    check = Check("give at rest", give.compliance * 1e6, error * 1e6, "µm/N", p_value)
    verdict = Verdict((check,))
    if verdict.fits:
        return verdict
    return verdict.blaming(
        "bristles, friction.dynamics: lugre with friction.bristle_stiffness of the order of "
        f"{1.0 / give.compliance:.1g} N/m (rodless identify bristles)"
    )
