# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""How far nodes reach: this machine alone, unless the user has settled it."""

import os
import socket

from rclpy.logging import get_logger

from rodless_base.ros.profiles import PROFILE_VARIABLES, is_left_to_us, of_this_machine
from rodless_base.ros.shared_memory import LOCALHOST, RANGE, prepare_shared_memory
from rodless_lab.session.errors import HarnessError

# Whoever has set one of these has settled how far their nodes reach.
SETTLED_BY = (
    RANGE,
    "ROS_LOCALHOST_ONLY",
    "ROS_STATIC_PEERS",
    "ROS_DISCOVERY_SERVER",
    "CYCLONEDDS_URI",
    *PROFILE_VARIABLES.values(),
)

LOOPBACK = "127.0.0.1"

# Nothing is sent there (RFC 863).
DISCARD_PORT = 9


def this_machine() -> dict[str, str]:
    """Environment variables that keep a process on this machine, where it is found quickly.

    With Fast DDS all sockets are bound to loopback. Shared memory is left out where there is no
    room for it, or with ``FASTDDS_BUILTIN_TRANSPORTS=UDPv4``. ROS's own ``LOCALHOST`` binds to all
    addresses; it is what other middlewares get, and a user's own profile of Fast DDS, which is left
    as it is. Raises HarnessError where there is no loopback, or no room.
    """
    check_loopback()
    if not is_left_to_us():
        return {RANGE: LOCALHOST}
    make_room_for_nodes()
    return of_this_machine()


def check_loopback() -> None:
    """Raise HarnessError where this machine does not reach itself: nodes would wait for ever."""
    try:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.connect((LOOPBACK, DISCARD_PORT))
    except OSError as error:
        raise HarnessError(
            f"{LOOPBACK} cannot be reached ({error.strerror}), and nodes talk over it: `ip "
            "link set lo up`, as root of this network"
        ) from error


def make_room_for_nodes() -> None:
    """Call :func:`prepare_shared_memory` and log what it says; raises HarnessError."""
    try:
        note = prepare_shared_memory()
    except RuntimeError as error:
        raise HarnessError(str(error)) from error
    if note is not None:
        get_logger("rodless").warning(note)


def stay_on_this_machine() -> None:
    """Keep this process and its children here, unless the environment settles how far they go."""
    if not any(os.environ.get(name) for name in SETTLED_BY):
        os.environ.update(this_machine())
