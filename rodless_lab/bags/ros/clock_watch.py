# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Time that goes to and fro, or does not come: a bag is not dated by it as it should be."""

from rclpy.node import Node

from rodless_base.ros.publish import nodes

# A clock that goes back so often is that of several plants. One that is reset goes back to 0.
MANY_STEPS = 20


class ClockWatch:
    """Counts how often the time of a clock goes back, but to 0."""

    def __init__(self) -> None:
        """Nothing has been told yet."""
        self._newest = 0
        self._steps = 0
        self._is_told = False

    def take(self, told: int) -> None:
        """Take the time (ns) that is told next."""
        self._steps += 0 < told < self._newest
        self._newest = told

    def look(self) -> bool:
        """Return whether it has become known that time goes to and fro; that is so once."""
        is_news = self._steps >= MANY_STEPS and not self._is_told
        self._is_told |= is_news
        return is_news


def torn_clock_text(observer: Node, topic: str) -> str:
    """Say so of the clock on ``topic``, who publishes it, and the way out."""
    publishers = sorted(nodes(observer.get_publishers_info_by_topic(topic)).values())
    return (
        f"{topic}: time goes to and fro there, and the times in the bag with it: published by "
        f"{', '.join(publishers) or 'nobody any more'}; let one plant alone publish it "
        "(publish_clock:=false or rodless rig --no-clock for the others), and record anew"
    )


def silent_clock_text(topic: str, waited: int) -> str:
    """Say that none came on ``topic`` while so many messages of another one ``waited``."""
    return (
        f"{topic}: no time came there before {waited} messages of another topic, so the whole bag "
        "is dated by the wall clock; for plant time let the rig run first"
    )
