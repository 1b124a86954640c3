# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What Fast DDS sends messages over: profiles of ours; a user's own are left as they are."""

import os
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

from rodless_base.ros.given import asked_for
from rodless_base.ros.share import share_directories
from rodless_base.ros.shared_memory import LOCALHOST, RANGE, TRANSPORTS, is_fast_dds

# Where Fast DDS looks for profiles: 2, up to jazzy, and 3, from kilted on.
PROFILE_VARIABLES = {2: "FASTRTPS_DEFAULT_PROFILES_FILE", 3: "FASTDDS_DEFAULT_PROFILES_FILE"}

# Profiles of a process that stays here: with shared memory, without, and for nodes in one process.
KINDS = ("", "_udp", "_one_process_here")

# Of one that goes as far as ROS does: for a node, and for nodes in one process.
ANYWHERE = "_anywhere"
ONE_PROCESS = "_one_process"

# Major version of rmw_fastrtps_cpp.
FIRST_WITH_FAST_DDS_3 = 9

# ROS leaves everything to the profile; for any other range it adds transports of its own.
UNCHANGED = "SYSTEM_DEFAULT"


def is_left_to_us() -> bool:
    """Whether it is Fast DDS, and no profile of the user's says what it sends messages over."""
    ours = ("", *map(_profile, (*KINDS, ANYWHERE, ONE_PROCESS)))
    return is_fast_dds() and _version_of_ros() > 0 and _given() in ours


def asks_at_once() -> bool:
    """Whether writers ask their readers every 20 ms what these lack, as our profiles say."""
    return is_left_to_us() and _given() != ""


def of_this_machine() -> dict[str, str]:
    """Environment variables that keep a process on this machine, where that is left to us."""
    kind = "_udp" if os.environ.get(TRANSPORTS) == "UDPv4" else ""
    return {RANGE: UNCHANGED, _variable(): _profile(kind)}


def leave_out_own_endpoints() -> None:
    """Keep DDS from delivering inside this process, unless the user has a profile of their own.

    To be called before the first node is made.
    """
    given = _given()
    if given in ("", _profile(ANYWHERE)):
        os.environ[_variable()] = _profile(ONE_PROCESS)
    elif given in map(_profile, KINDS):
        os.environ[_variable()] = _profile("_one_process_here")


def settle_transports(arguments: Sequence[str]) -> None:
    """Let nodes that are given ``arguments`` send as a rig needs it, where that is left to us.

    They repeat at once what was lost, and learn as soon what has been received. In real time they
    talk over UDP. To be called before the first node is made.
    """
    if not is_left_to_us():
        return
    if asked_for(arguments, "plant", "time.mode") != "lockstep":
        _leave_out_shared_memory()
    if _given() == "":
        os.environ[_variable()] = _profile(ANYWHERE)


def _leave_out_shared_memory() -> None:
    """Talk over UDP, unless the user has asked for other transports, as with ``DEFAULT``.

    Over shared memory a reader that has stopped holds whoever writes to it for 2 s at a time: once
    Fast DDS has given its port up, two writers that make it anew can lock each other out
    (SharedMemGlobal.hpp, ``~Port`` inside of ``open_port_internal``, for twice
    BOOST_INTERPROCESS_TIMEOUT_WHEN_LOCKING_DURATION_MS). A rig in real time waits for nobody; one
    in lock-step waits anyway, and is twice as fast with it.
    """
    if (os.environ.get(TRANSPORTS) or "UDPv4") != "UDPv4":
        return
    if os.environ.get(RANGE) == LOCALHOST and not os.environ.get("ROS_STATIC_PEERS"):
        # With this range ROS adds shared memory, whatever else is set. Our profiles reach as far.
        inside = _given() == _profile(ONE_PROCESS)
        os.environ[_variable()] = _profile("_one_process_here" if inside else "_udp")
        os.environ[RANGE] = UNCHANGED
    elif _given() == _profile(""):
        os.environ[_variable()] = _profile("_udp")
    os.environ[TRANSPORTS] = "UDPv4"


def _given() -> str:
    return os.environ.get(_variable(), "")


def _variable() -> str:
    return PROFILE_VARIABLES[_version()]


def _profile(kind: str) -> str:
    """Return the file in the spelling of the Fast DDS here; it refuses one in another's."""
    return str(Path(__file__).with_name(f"fast_dds_{_version()}{kind}.xml"))


def _version() -> int:
    return 3 if _version_of_ros() >= FIRST_WITH_FAST_DDS_3 else 2


@cache
def _version_of_ros() -> int:
    """Major version of ROS's layer above Fast DDS, 0 where there is none."""
    for share in share_directories("rmw_fastrtps_cpp", beside="rclpy"):
        if (share / "package.xml").is_file():
            manifest = ElementTree.parse(share / "package.xml").getroot()
            return int(manifest.findtext("version", "0").partition(".")[0])
    return 0
