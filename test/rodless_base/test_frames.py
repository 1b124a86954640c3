# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Names of frames and joints with a prefix."""

import pytest

from rodless_base.constants import CARRIAGE
from rodless_base.frames import joint_among
from rodless_base.parameters import ParameterError, ParameterSet
from rodless_control import ControllerParameters
from rodless_sim import RigParameters


@pytest.mark.parametrize("kind", [RigParameters, ControllerParameters])
def test_a_prefix_is_taken_as_it_stands_and_a_leading_slash_refused(
    kind: type[ParameterSet],
) -> None:
    """As robot_state_publisher takes it; tf2 refuses frames with a leading slash."""
    assert kind()["frame_prefix"] == ""
    assert kind({"frame_prefix": "left/"})["frame_prefix"] == "left/"
    with pytest.raises(ParameterError, match="no leading slash; write 'left/'"):
        kind({"frame_prefix": "/left/"})


@pytest.mark.parametrize(
    ("names", "found"),
    [
        (["carriage"], "carriage"),
        (["left/carriage"], "left/carriage"),
        (["a", "left_carriage", "b"], "left_carriage"),
        (["left/carriage", "carriage"], "carriage"),
        (["left/carriage", "right/carriage"], None),
        (["carriage/a"], None),
        ([], None),
    ],
)
def test_the_carriage_is_found_under_any_prefix(names: list[str], found: str | None) -> None:
    """The bare name first; two with prefixes are not guessed between."""
    assert joint_among(CARRIAGE, names) == found
