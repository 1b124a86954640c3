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
