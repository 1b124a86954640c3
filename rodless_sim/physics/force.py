# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A force on the carriage, and how it changes with the motion."""

from typing import NamedTuple

from rodless_base.kernels import kernel


class Force(NamedTuple):
    """A force, positive toward chamber B's end, with its derivatives."""

    force: float  # N
    by_position: float  # N/m
    by_velocity: float  # N·s/m


NO_FORCE = Force(0.0, 0.0, 0.0)


@kernel
def together(one: Force, other: Force) -> Force:
    """The sum of two forces."""
    return Force(
        one.force + other.force,
        one.by_position + other.by_position,
        one.by_velocity + other.by_velocity,
    )
