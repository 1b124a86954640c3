# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Whether what a test sends arrives."""

import math
import time
from collections.abc import Callable

from rclpy.node import Node
from rclpy.publisher import Publisher

from rodless_base.ros.publish import UNKNOWN, nodes
from rodless_lab.session.running_rig import PLANT

# For how long (s) after a reader has come or gone the middleware may still list it otherwise.
SETTLES = 1.0


class PlantHears:
    """Whether the plant hears a publisher of commands.

    One that was stopped for 20 s is given up by the middleware. It goes on before it is found
    again, and what is sent until then is lost: a plant in lock-step would wait for it for good.
    """

    def __init__(
        self, node: Node, publisher: Publisher, now: Callable[[], float] = time.monotonic
    ) -> None:
        """Ask for the plant of ``node``'s namespace; ``now`` is a steady time in s."""
        self._node = node
        self._publisher = publisher
        self._now = now
        self._count = 0
        self._hears = self._has_heard = False
        self._changed = -math.inf

    def __call__(self) -> bool:
        """Return whether it does now."""
        # Counting readers costs next to nothing, asking who they are a tenth of a millisecond.
        count, now = self._publisher.get_subscription_count(), self._now()
        if count != self._count:
            self._count, self._changed = count, now
        if not self._hears or now - self._changed < SETTLES:
            self._hears = self._is_listed()
            self._has_heard |= self._hears
        return self._hears

    @property
    def silence(self) -> str:
        """Say that what the test answers is kept back, and why, if so."""
        if self() or not self._has_heard:
            return ""
        return (
            f"; the test answers nothing, as the middleware takes {PLANT} for gone (a process that "
            "was stopped for 20 s is): where it does not find it again, begin a new session"
        )

    def _is_listed(self) -> bool:
        readers = self._node.get_subscriptions_info_by_topic(self._publisher.topic_name)
        plant = self._node.resolve_topic_name(PLANT)
        # The name of one that has just been found is not known yet.
        return not {plant, UNKNOWN}.isdisjoint(nodes(readers).values())
