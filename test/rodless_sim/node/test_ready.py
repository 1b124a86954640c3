"""What the plant says of itself once it is ready."""

import pytest

from rodless_sim import RigParameters
from rodless_sim.node.ready import ready_line


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        (
            {},
            "ready: realtime, 1000 Hz, supply 0.520 MPa gauge; "
            "waiting for commands on /a/valve/voltage",
        ),
        (
            {"time.period": 5e-3, "time.speed": 2.0, "supply.pressure": 501325.0},
            "ready: realtime, 200 Hz at speed 2, supply 0.400 MPa gauge; "
            "waiting for commands on /a/valve/voltage",
        ),
        (
            {"time.recorders": 2},
            "ready: realtime, 1000 Hz, supply 0.520 MPa gauge; "
            "waiting for 3 subscribers to /a/joint_states and commands on /a/valve/voltage",
        ),
        (
            {"time.mode": "lockstep"},
            "ready: lockstep, 1000 samples per second of plant time, supply 0.520 MPa gauge; "
            "waiting for a subscriber to /a/joint_states and one publisher on /a/valve/voltage",
        ),
    ],
)
def test_the_line_says_mode_rate_supply_and_what_is_waited_for(
    changes: dict[str, object], expected: str
) -> None:
    """Pressures are gauge, topics as they are resolved."""
    assert ready_line(RigParameters(changes), "/a/joint_states", "/a/valve/voltage") == expected
