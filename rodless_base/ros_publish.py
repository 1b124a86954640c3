"""Publish only what somebody reads: building a message costs as much as sending it."""

from collections.abc import Callable
from typing import Any

from rclpy.duration import Duration
from rclpy.publisher import Publisher


class OnDemand:
    """A publisher that builds and sends messages while it has subscribers.

    Their number is looked up in :meth:`look` only, which its owner calls now and then: asking
    every time costs as much as what it saves.
    """

    def __init__(self, publisher: Publisher, message: Callable[..., Any]) -> None:
        """Send what ``message`` makes of the values to publish."""
        self._publisher = publisher
        self._message = message
        self.subscribers = 0

    def look(self) -> int:
        """Look up and return the number of subscribers."""
        self.subscribers = int(self._publisher.get_subscription_count())
        return self.subscribers

    def wait_for_all_acked(self, patience: Duration) -> None:
        """Return once all messages have arrived where they are read, or after ``patience``."""
        if self.subscribers:
            self._publisher.wait_for_all_acked(patience)

    def publish(self, *values: object) -> None:
        """Send the message of ``values`` to the subscribers of the last look, if any."""
        if self.subscribers:
            self._publisher.publish(self._message(*values))
