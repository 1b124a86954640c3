# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""One joint's position out of a message of several."""

import pytest
from sensor_msgs.msg import JointState

from rodless_base.ros.joint import joint_position


def test_a_joint_is_found_by_its_name() -> None:
    """Wherever it stands among the others, as a float."""
    for names in (["a"], ["a", "b"], ["b", "a", "c"]):
        positions = [float(ord(name)) for name in names]
        found = joint_position(JointState(name=names, position=positions), "a")
        assert type(found) is float
        assert found == float(ord("a"))


@pytest.mark.parametrize(
    "message",
    [
        JointState(),
        JointState(name=["a"]),
        JointState(position=[0.1]),
        JointState(name=["b"], position=[0.1]),
        JointState(name=["b", "a"], position=[0.1]),
        JointState(name=["a"], position=[0.1, 0.2]),
        JointState(name=["a", "a"], position=[0.1, 0.2]),
    ],
)
def test_a_message_that_does_not_tell_it_gives_none(message: JointState) -> None:
    """No such name, or two, or positions that are not as many as the names."""
    assert joint_position(message, "a") is None
