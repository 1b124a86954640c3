# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Which clock tells the time of the rig that a topic belongs to."""

from rodless_base.topics import (
    JOINT_COMMANDS,
    OPTIONAL_TOPICS,
    RIG_CLOCK,
    RIG_TOPICS,
    THROTTLED,
)

# How a rig names what is recorded of it; of its controller there may be more.
_CONTROLLER = "controller/"
_OF_A_RIG = (RIG_CLOCK, *RIG_TOPICS, *OPTIONAL_TOPICS, JOINT_COMMANDS)
# Some names end in another one.
_NAMES = sorted((*_OF_A_RIG, *(f"{THROTTLED}{name}" for name in _OF_A_RIG)), key=len, reverse=True)


def rig_clock(topic: str) -> str:
    """Return the name of the clock of the rig in whose namespace ``topic`` is.

    Empty for a rig without a namespace, and for what no rig publishes or listens to.

    Examples
    --------
    >>> rig_clock("/left/valve/voltage"), rig_clock("/cell/left/controller/reference")
    ('/left/clock', '/cell/left/clock')
    >>> rig_clock("/valve/voltage"), rig_clock("/controller/reference"), rig_clock("/left/camera")
    ('', '', '')
    """
    namespace = _namespace(topic)
    return f"{namespace}/{RIG_CLOCK}" if namespace else ""


def _namespace(topic: str) -> str:
    for name in _NAMES:
        if topic.endswith(f"/{name}"):
            return topic.removesuffix(f"/{name}")
    before, of_controller, term = topic.rpartition(f"/{_CONTROLLER}")
    return before.removesuffix("/_throttled") if of_controller and "/" not in term else ""
