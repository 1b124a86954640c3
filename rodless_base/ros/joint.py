# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""One joint of a JointState."""

from sensor_msgs.msg import JointState

from rodless_base.constants import CARRIAGE
from rodless_base.frames import joint_among


def joint_position(message: JointState, name: str) -> float | None:
    """Return the position (m) of the joint ``name``, or None where the message has none.

    Positions that are not as many as the names belong to no joint for certain, nor do two.
    """
    if message.name.count(name) != 1 or len(message.position) != len(message.name):
        return None
    return float(message.position[message.name.index(name)])


def carriage_position(message: JointState) -> float | None:
    """Return the position (m) of the carriage, whatever its prefix, or None without one."""
    name = joint_among(CARRIAGE, message.name)
    return None if name is None else joint_position(message, name)
