"""Callbacks that are told when a message was sent and received, under every executor."""

from collections.abc import Callable, Mapping
from functools import wraps
from typing import Any

# What rclpy tells about a message beside its content; times in ns of the system's clock.
Info = Mapping[str, Any]


def with_info(receive: Callable[[Any, Info], None]) -> Callable[..., None]:
    """Make ``receive`` a callback with message information under every executor.

    rclpy reads from its signature that it wants the information; the events executor then hands
    both over as one pair, the others as two arguments.
    """

    @wraps(receive)
    def callback(*arguments: Any) -> None:
        receive(*(arguments[0] if len(arguments) == 1 else arguments))

    return callback
