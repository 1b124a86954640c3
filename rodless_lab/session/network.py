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
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

from rclpy.logging import get_logger

from rodless_base.ros.share import share_directories
from rodless_base.ros.shared_memory import (
    LOCALHOST,
    RANGE,
    TRANSPORTS,
    is_fast_dds,
    prepare_shared_memory,
)
from rodless_lab.session.errors import HarnessError

# Where Fast DDS looks for profiles: 2, up to jazzy, and 3, from kilted on.
PROFILE_VARIABLES = {2: "FASTRTPS_DEFAULT_PROFILES_FILE", 3: "FASTDDS_DEFAULT_PROFILES_FILE"}

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

# Profiles of a process that stays here: with shared memory, without, and for nodes in one process.
KINDS = ("", "_udp", "_one_process_here")

# Major version of rmw_fastrtps_cpp.
FIRST_WITH_FAST_DDS_3 = 9


def this_machine() -> dict[str, str]:
    """Environment variables that keep a process on this machine, where it is found quickly.

    With Fast DDS all sockets are bound to loopback. Shared memory is left out where there is no
    room for it, or with ``FASTDDS_BUILTIN_TRANSPORTS=UDPv4``. ROS's own ``LOCALHOST`` binds to all
    addresses; it is what other middlewares get, and a user's own profile of Fast DDS, which is left
    as it is. Raises HarnessError where there is no loopback, or no room.
    """
    check_loopback()
    if not (is_fast_dds() and _rmw_version()) or _given_profile() not in (
        "",
        *map(_profile, KINDS),
    ):
        return {RANGE: LOCALHOST}
    make_room_for_nodes()
    profile = _profile("_udp" if os.environ.get(TRANSPORTS) == "UDPv4" else "")
    # All is in the profile: for any other range ROS adds transports of its own.
    return {RANGE: "SYSTEM_DEFAULT", _variable(): profile}


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


def leave_out_own_endpoints() -> None:
    """Keep DDS from delivering inside this process, unless the user has a profile of their own.

    To be called before the first node is made.
    """
    given = _given_profile()
    if given == "":
        os.environ[_variable()] = _profile("_one_process")
    elif given in map(_profile, KINDS):
        os.environ[_variable()] = _profile("_one_process_here")


def _given_profile() -> str:
    return os.environ.get(_variable(), "")


def _variable() -> str:
    return PROFILE_VARIABLES[_version()]


def _profile(kind: str) -> str:
    """Return the file in the spelling of the Fast DDS here; it refuses one in another's."""
    return str(Path(__file__).with_name(f"fast_dds_{_version()}{kind}.xml"))


def _version() -> int:
    return 3 if _rmw_version() >= FIRST_WITH_FAST_DDS_3 else 2


@cache
def _rmw_version() -> int:
    """Major version of ROS's layer above Fast DDS, 0 where there is none."""
    for share in share_directories("rmw_fastrtps_cpp", beside="rclpy"):
        if (share / "package.xml").is_file():
            manifest = ElementTree.parse(share / "package.xml").getroot()
            return int(manifest.findtext("version", "0").partition(".")[0])
    return 0
