# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Controllers reduced to what a test looks at."""

from collections.abc import Callable

import pytest

from rodless_control import PidParameters

NOTHING = {
    "kp": 0.0,
    "ki": 0.0,
    "kd": 0.0,
    "feedforward": 0.0,
    "integral_zone": 10.0,
    "error_dead_band": 0.0,
    "dead_zone_voltage": 0.0,
    "neutral_voltage": 5.0,
    "anti_windup": "none",
}


@pytest.fixture
def bare() -> Callable[..., PidParameters]:
    """Make parameters of a law of which only what is given acts: neutral 5 V, limits 0-10 V."""

    def make(**values: object) -> PidParameters:
        chosen = {**NOTHING, **values}
        return PidParameters({f"controller.{name}": value for name, value in chosen.items()})

    return make
