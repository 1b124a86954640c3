# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Which profile of Fast DDS a process has: no shared memory in real time, a user's own kept."""

import os
from pathlib import Path

import pytest

from rodless_base.ros import profiles
from rodless_base.ros.profiles import (
    ANYWHERE,
    ONE_PROCESS,
    PROFILE_VARIABLES,
    leave_out_own_endpoints,
    of_this_machine,
    settle_transports,
)
from rodless_base.ros.shared_memory import RANGE, TRANSPORTS

FOLDER = Path(profiles.__file__).parent

REAL_TIME = ["plant"]
LOCKSTEP = ["plant", "--ros-args", "-p", "time.mode:=lockstep"]


@pytest.fixture
def bare(monkeypatch: pytest.MonkeyPatch) -> pytest.MonkeyPatch:
    """Leave nothing in the environment that says what messages are sent over."""
    unset = (RANGE, TRANSPORTS, "ROS_STATIC_PEERS", "RMW_IMPLEMENTATION")
    for name in (*unset, *PROFILE_VARIABLES.values()):
        monkeypatch.setenv(name, "")
        monkeypatch.delenv(name)
    return monkeypatch


def profile() -> str:
    """Return the kind of the profile in the environment; "none" where there is none."""
    paths = {os.environ.get(variable, "") for variable in PROFILE_VARIABLES.values()} - {""}
    return Path(paths.pop()).stem[len("fast_dds_N") :] if paths else "none"


@pytest.mark.parametrize(
    ("reach", "own_endpoints", "kind"),
    [
        (None, True, ANYWHERE),
        (None, False, ONE_PROCESS),
        ("here", True, "_udp"),
        ("here", False, "_one_process_here"),
        ("LOCALHOST", True, "_udp"),
        ("LOCALHOST", False, "_one_process_here"),
        ("SUBNET", True, ANYWHERE),
    ],
)
def test_in_real_time_nodes_do_without_shared_memory(
    bare: pytest.MonkeyPatch, reach: str | None, own_endpoints: bool, kind: str
) -> None:
    """Over UDP as far as they were to reach; with ROS's LOCALHOST a profile of ours says it."""
    settings = of_this_machine() if reach == "here" else {RANGE: reach} if reach else {}
    for name, value in settings.items():
        bare.setenv(name, value)
    bare.setattr(os, "environ", os.environ.copy())
    if not own_endpoints:
        leave_out_own_endpoints()
    settle_transports(REAL_TIME)
    assert profile() == kind
    assert os.environ[TRANSPORTS] == "UDPv4"
    stays = reach in ("here", "LOCALHOST")
    assert os.environ.get(RANGE) == ("SYSTEM_DEFAULT" if stays else reach)


@pytest.mark.parametrize(
    "settings",
    [
        {"RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp"},
        dict.fromkeys(PROFILE_VARIABLES.values(), "/home/me/mine.xml"),
    ],
)
def test_what_a_user_has_settled_stands(bare: pytest.MonkeyPatch, settings: dict[str, str]) -> None:
    """Transports, another middleware, a profile of their own."""
    for name, value in settings.items():
        bare.setenv(name, value)
    before = dict(os.environ)
    settle_transports(REAL_TIME)
    assert dict(os.environ) == before


@pytest.mark.parametrize("reach", ["SUBNET", "LOCALHOST"])
@pytest.mark.parametrize("transports", ["DEFAULT", "SHM"])
def test_transports_of_a_user_stand(bare: pytest.MonkeyPatch, transports: str, reach: str) -> None:
    """Whoever wants shared memory in real time has it."""
    bare.setattr(os, "environ", {**os.environ, TRANSPORTS: transports, RANGE: reach})
    settle_transports(REAL_TIME)
    found = profile(), os.environ[TRANSPORTS], os.environ[RANGE]
    assert found == (ANYWHERE, transports, reach)


def test_peers_of_a_user_are_kept(bare: pytest.MonkeyPatch) -> None:
    """LOCALHOST with static peers reaches further than our profile, which knows none."""
    bare.setenv(RANGE, "LOCALHOST")
    bare.setenv("ROS_STATIC_PEERS", "192.168.7.7")
    bare.setattr(os, "environ", os.environ.copy())
    settle_transports(REAL_TIME)
    assert (os.environ[RANGE], profile()) == ("LOCALHOST", ANYWHERE)


def test_in_lock_step_shared_memory_stays(bare: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Wherever that is asked for, by a file or one by one; which comes last is taken."""
    file = tmp_path / "mine.yaml"
    file.write_text("/**/plant: {ros__parameters: {time: {mode: lockstep}}}")
    of_file = ["plant", "--ros-args", "--params-file", str(file)]
    bare.setattr(os, "environ", os.environ.copy())
    for arguments in (LOCKSTEP, of_file, [*of_file, "-p", "supply.pressure:=6e5"]):
        settle_transports(arguments)
        assert (profile(), TRANSPORTS in os.environ) == (ANYWHERE, False)
    settle_transports([*of_file, "-p", "plant:time.mode:=realtime"])
    assert os.environ[TRANSPORTS] == "UDPv4"


def test_nodes_in_one_process_reach_as_far_as_before(bare: pytest.MonkeyPatch) -> None:
    """What `ros2 run` starts goes on to the network, what stays here stays here."""
    with bare.context() as patch:
        patch.setattr(os, "environ", os.environ.copy())
        leave_out_own_endpoints()
        assert profile() == ONE_PROCESS
    bare.setattr(os, "environ", os.environ.copy())
    os.environ.update(of_this_machine())
    leave_out_own_endpoints()
    assert profile() == "_one_process_here"


def lines(name: str) -> list[str]:
    """Return a profile without its comments."""
    text = (FOLDER / name).read_text(encoding="utf-8")
    return [line for line in text.splitlines() if "<!--" not in line]


def without(some: list[str], first: str, last: str) -> list[str]:
    """Leave out what stands between two lines, these included."""
    texts = [line.strip() for line in some]
    return some[: texts.index(first)] + some[texts.index(last) + 1 :]


@pytest.mark.parametrize("version", [2, 3])
def test_profiles_differ_in_nothing_but_their_purpose(version: int) -> None:
    """Shared memory, delivery inside a process, loopback; and one word between the versions."""
    udp = lines(f"fast_dds_{version}_udp.xml")
    shared = [line for line in lines(f"fast_dds_{version}.xml") if "shared_memory" not in line]
    kinds = [line.strip() for line in shared]
    shm = kinds.index("<type>SHM</type>")
    assert shared[: shm - 1] + shared[shm + 2 :] == udp
    inside = lines(f"fast_dds_{version}_one_process_here.xml")
    assert without(inside, "<propertiesPolicy>", "</propertiesPolicy>") == udp
    here = without(inside, "<transport_descriptors>", "</transport_descriptors>")
    here = without(here, "<useBuiltinTransports>false</useBuiltinTransports>", "</userTransports>")
    here = without(here, "<metatrafficUnicastLocatorList>", "</initialPeersList>")
    one_process = lines(f"fast_dds_{version}_one_process.xml")
    assert here == one_process
    anywhere = lines(f"fast_dds_{version}_anywhere.xml")
    assert without(one_process, "<propertiesPolicy>", "</propertiesPolicy>") == anywhere
    if version == 3:
        two = [
            line.replace("heartbeatPeriod", "heartbeat_period") for line in lines("fast_dds_2.xml")
        ]
        assert two == lines("fast_dds_3.xml")
