# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Commands on their way to the valve, for a rig that is advanced by spans of any length.

What :mod:`rodless_sim.physics.dead_time` does for one command per sample period.
"""

from typing import NamedTuple


class Commands(NamedTuple):
    """The command at the valve and those still under way to it."""

    arrived: float  # V
    under_way: tuple[tuple[int, float], ...] = ()  # when it was given (ns), V

    def during(
        self, voltage: float, now: int, span: int, dead_time: int
    ) -> tuple[list[tuple[float, int]], "Commands"]:
        """Give a ``voltage`` (V) ``now`` and let ``span`` pass; all times in ns.

        Returns which voltages are at the valve meanwhile, each with how long, and the commands
        then. One that is like the one before is not sent: it would change nothing.
        """
        under_way = list(self.under_way)
        if voltage != (under_way[-1][1] if under_way else self.arrived):
            under_way.append((now, voltage))
        at_valve, since, end = self.arrived, now, now + span
        pieces: list[tuple[float, int]] = []
        while under_way and under_way[0][0] + dead_time < max(end, now + 1):
            given, following = under_way.pop(0)
            if given + dead_time > since:
                pieces.append((at_valve, given + dead_time - since))
                since = given + dead_time
            at_valve = following
        return [*pieces, (at_valve, end - since)], Commands(at_valve, tuple(under_way))
