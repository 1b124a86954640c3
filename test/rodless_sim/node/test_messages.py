"""What the plant says of its valve."""

from rodless_sim.node import messages


def test_the_state_of_the_valve_is_in_metres_and_volts() -> None:
    """At 10 V the spool of eq. (24) stands 1.0635 mm from its middle; at 5.05 V it stands there."""
    state = messages.valve_state(10.0, 1_234_567_890)
    assert (state.header.stamp.sec, state.header.stamp.nanosec) == (1, 234_567_890)
    assert list(state.name) == ["valve_spool"]
    assert list(state.effort) == [10.0]
    assert abs(state.position[0] - 1.06351e-3) < 1e-12
    assert abs(messages.valve_state(5.05, 0).position[0]) < 1e-8
    assert not state.velocity
