# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The controller's parameters: what may not stand together, and what the presets hold."""

import pytest

from rodless_base.parameter_file import preset_names
from rodless_control import ParameterError, PidParameters


@pytest.mark.parametrize(
    ("low", "neutral", "high"),
    [(5.0, 4.9, 10.0), (0.0, 6.0, 5.5), (5.0, 5.0, 10.0), (0.0, 6.0, 6.0), (8.0, 5.0, 2.0)],
)
def test_the_neutral_voltage_lies_between_the_limits(
    low: float, neutral: float, high: float
) -> None:
    """A closed valve that cannot be commanded is refused, with all three values in the message."""
    values = {
        "controller.minimum_voltage": low,
        "controller.neutral_voltage": neutral,
        "controller.maximum_voltage": high,
    }
    with pytest.raises(ParameterError, match=r"controller\.neutral_voltage") as refusal:
        PidParameters(values)
    for value in (low, neutral, high):
        assert f"{value:g} V" in str(refusal.value)


def test_limits_that_contain_the_neutral_voltage_are_taken() -> None:
    """They may be as close as one likes, and move together in one change."""
    values = {"controller.minimum_voltage": 5.07, "controller.maximum_voltage": 5.09}
    assert PidParameters(values).number("controller.maximum_voltage") == 5.09
    shifted = {
        "controller.minimum_voltage": 8.0,
        "controller.neutral_voltage": 8.5,
        "controller.maximum_voltage": 9.0,
    }
    assert PidParameters(values).with_values(shifted).number("controller.neutral_voltage") == 8.5


@pytest.mark.parametrize("kind", ["conditional", "", None, 1])
def test_only_known_ways_of_anti_windup_are_taken(kind: object) -> None:
    """A misspelt choice is refused and the message lists the choices."""
    with pytest.raises(ParameterError, match=r"controller\.anti_windup.*back_calculation"):
        PidParameters({"controller.anti_windup": kind})


@pytest.mark.parametrize("name", preset_names())
def test_presets_read(name: str) -> None:
    """Each preset that ships is a valid set for the controller."""
    assert PidParameters.preset(name).number("controller.kp") > 0.0
