"""Messages that cannot be sent are counted, not forgotten."""

from typing import Any

import pytest
from rclpy.impl.implementation_singleton import rclpy_implementation
from std_msgs.msg import Float64

from rodless_base.ros import publish
from rodless_base.ros.publish import OnDemand, send


class Stopped:
    """A lossless publisher whose subscriber stops reading after some messages."""

    def __init__(self, room: int) -> None:
        self.room = room
        self.sent: list[float] = []

    def get_subscription_count(self) -> int:
        """One, which still is there."""
        return 1

    def publish(self, message: Float64) -> None:
        """Send, or fail as rclpy does where there is no room."""
        if len(self.sent) == self.room:
            raise rclpy_implementation.RCLError("timeout")
        self.sent.append(message.data)


def publisher(room: int) -> Any:
    """Return one as rclpy's."""
    return Stopped(room)


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Give a subscriber up at once."""
    monkeypatch.setattr(publish, "READER_TIMEOUT", 0.0)


def test_a_message_lost_to_a_stopped_subscriber_is_reported() -> None:
    """What fits is sent, what does not is lost, and the caller is told."""
    stopped = publisher(room=1)
    assert send(stopped, Float64(data=1.0))
    assert not send(stopped, Float64(data=2.0))
    assert stopped.sent == [1.0]


def test_messages_on_demand_count_what_is_lost() -> None:
    """Only what somebody should have had counts."""
    stopped = publisher(room=2)
    on_demand = OnDemand(stopped, lambda value: Float64(data=value))
    on_demand.publish(0.0)
    assert (stopped.sent, on_demand.lost) == ([], 0)
    on_demand.poll()
    for value in (1.0, 2.0, 3.0, 4.0):
        on_demand.publish(value)
    assert (stopped.sent, on_demand.lost) == ([1.0, 2.0], 2)
