"""Publish only what somebody reads: building a message costs as much as sending it."""

from collections.abc import Callable
from time import monotonic
from typing import Any

from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.publisher import Publisher

# What /diagnostics calls messages that send() has lost.
LOST = "messages lost to a stopped subscriber"

# How long (s) a reader that has stopped reading may hold a lossless publisher back.
READER_TIMEOUT = 5.0


def send(publisher: Publisher, message: object) -> bool:
    """Publish, waiting for a reader that holds a lossless publisher back.

    Returns False where one did so for ``READER_TIMEOUT``; the message is lost then.
    """
    end = None
    while True:
        try:
            publisher.publish(message)
        except rclpy_implementation.RCLError:
            end = end or monotonic() + READER_TIMEOUT
            if monotonic() > end:
                return False
        else:
            return True


class OnDemand:
    """A publisher that builds and sends messages while it has subscribers.

    Their number is looked up in :meth:`poll` only, which its owner calls now and then: asking
    every time costs as much as what it saves.
    """

    def __init__(self, publisher: Publisher, message: Callable[..., Any]) -> None:
        """Send what ``message`` makes of the values to publish."""
        self._publisher = publisher
        self._message = message
        self.subscribers = 0
        self.lost = 0  # messages, to a stopped subscriber

    def poll(self) -> int:
        """Look up and return the number of subscribers."""
        self.subscribers = int(self._publisher.get_subscription_count())
        return self.subscribers

    def publish(self, *values: object) -> None:
        """Send the message of ``values`` to the subscribers of the last poll, if any."""
        if self.subscribers:
            self.lost += not send(self._publisher, self._message(*values))
