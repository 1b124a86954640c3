# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""How long a step may be: what motion allows beside the error."""

from rodless_base.kernels import kernel

# What happens within a longer step might leave no trace at its end.
LONGEST_STEP = 1e-3  # s

# About one step is taken in a millisecond. So many in one call, and so many for each second of it,
# mean that the rig cannot be followed.
MOST_STEPS = 100_000
MOST_STEPS_PER_SECOND = 1e6

# Where friction falls with speed, the motion runs away from itself, and that is what makes
# stick-slip. An L-stable method would damp it: there a step is at most this share of the time
# constant.
UNSTABLE_SHARE = 0.25
# The fall ends at about this many Stribeck velocities; a step changes the speed there by at most
# this share of one, or it would jump the curve without having seen it.
FALL = 2.5
FALL_SHARE = 0.5
# There an error in the speed grows until the fall is over: it may be smaller by this factor.
FALL_ACCURACY = 10.0


@kernel
def step_within(left: float, step: float) -> float:
    """Return the step to try, up to ``step``, of the ``left`` s of a period: no sliver is left."""
    step = min(step, LONGEST_STEP)
    if step >= left:
        return left
    if step > 0.5 * left:
        return 0.5 * left
    return step


@kernel
def may_fall(speed: float, stribeck_velocity: float) -> bool:
    """Whether friction may fall with speed at ``speed`` (m/s)."""
    return abs(speed) < 3.0 * stribeck_velocity


@kernel
def step_in_the_fall(
    speed: float, after: float, slope: float, stribeck_velocity: float, step: float
) -> float:
    """Return the step to try instead of one from ``speed`` to ``after`` (m/s), or ``step`` itself.

    ``slope`` is how the acceleration grows with the velocity at its end, 1/s.
    """
    if may_fall(after, stribeck_velocity) and slope * step > UNSTABLE_SHARE:
        return 0.8 * UNSTABLE_SHARE / slope
    change = abs(after - speed)
    edge = FALL * stribeck_velocity
    if change > FALL_SHARE * stribeck_velocity and min(speed, after) < edge:
        # First to the edge of the fall, then along it.
        ahead = speed - 0.96 * edge if speed > edge else 0.0
        return step * min(0.9, max(ahead, 0.8 * FALL_SHARE * stribeck_velocity) / change)
    return step
