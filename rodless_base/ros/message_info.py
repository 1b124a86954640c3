# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Callbacks that are told when a message was sent and received, under every executor."""

import math
from collections.abc import Callable, Mapping
from functools import wraps
from time import time_ns
from typing import Any
from weakref import WeakSet

from rclpy.subscription import Subscription

# What rclpy tells about a message beside its content; times in ns of the system's clock.
Info = Mapping[str, Any]

_with_info: "WeakSet[Callable[..., None]]" = WeakSet()


def with_info(receive: Callable[[Any, Info], None]) -> Callable[..., None]:
    """Make ``receive`` a callback with message information under every executor.

    rclpy reads from its signature that it wants the information; the events executor then hands
    both over as one pair, the others as two arguments.
    """

    @wraps(receive)
    def callback(*arguments: Any) -> None:
        receive(*(arguments[0] if len(arguments) == 1 else arguments))

    _with_info.add(callback)
    return callback


def wants_info(callback: Callable[..., None]) -> bool:
    """Whether ``callback`` was made by :func:`with_info`, or wraps such a one."""
    return callback in _with_info or getattr(callback, "__wrapped__", None) in _with_info


def take_waiting(subscription: Subscription, until: float = math.inf) -> None:
    """Run the callback of ``subscription``, and no other one, for what has come.

    Up to the first message that was sent at ``until`` (ns, wall clock) or later.
    """
    receive, waiting = subscription.callback, subscription.handle
    with waiting:
        while (taken := waiting.take_message(subscription.msg_type, subscription.raw)) is not None:
            receive(*(taken if wants_info(receive) else taken[:1]))
            if taken[1]["source_timestamp"] >= until:
                return


def delivered_now(sequence: int) -> Info:
    """Return the information of a publisher's message that is sent and received at this moment."""
    now = time_ns()
    return {
        "source_timestamp": now,
        "received_timestamp": now,
        "publication_sequence_number": sequence,
    }
