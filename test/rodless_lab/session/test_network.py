# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Rigs of the product's own stay on this machine, unless the user has settled it otherwise."""

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import psutil
import pytest
from running import StartProcess, until_it_says

from rodless_base.ros.profiles import PROFILE_VARIABLES, leave_out_own_endpoints
from rodless_base.ros.shared_memory import RANGE
from rodless_lab.session.network import SETTLED_BY, stay_on_this_machine, this_machine

LOOPBACK = "127.0.0.1"

# Of a start that compiles, on a crowded machine, in wall-clock s.
FIRST_START = 240.0


@pytest.fixture
def bare(monkeypatch: pytest.MonkeyPatch) -> pytest.MonkeyPatch:
    """Leave nothing in the environment that says how far nodes reach."""
    for name in (*SETTLED_BY, "RMW_IMPLEMENTATION", "FASTDDS_BUILTIN_TRANSPORTS"):
        monkeypatch.setenv(name, "")
        monkeypatch.delenv(name)
    return monkeypatch


def profile(environment: dict[str, str]) -> str:
    """Return the name of the profile that an environment names."""
    (path,) = (value for name, value in environment.items() if name in PROFILE_VARIABLES.values())
    assert Path(path).is_file()
    return Path(path).name


def test_a_profile_binds_to_loopback(bare: pytest.MonkeyPatch) -> None:
    """With it ROS adds no transports of its own; without shared memory where that is asked for."""
    environment = this_machine()
    assert environment[RANGE] == "SYSTEM_DEFAULT"
    assert profile(environment) in ("fast_dds_2.xml", "fast_dds_3.xml")
    bare.setenv("FASTDDS_BUILTIN_TRANSPORTS", "UDPv4")
    assert profile(this_machine()).endswith("_udp.xml")


def test_settings_of_the_user_stand(bare: pytest.MonkeyPatch) -> None:
    """A profile of their own and another middleware get ROS's LOCALHOST, and no file of ours."""
    with bare.context() as patch:
        patch.setenv("RMW_IMPLEMENTATION", "rmw_cyclonedds_cpp")
        assert this_machine() == {RANGE: "LOCALHOST"}
    for variable in PROFILE_VARIABLES.values():
        bare.setenv(variable, "/home/me/mine.xml")
    assert this_machine() == {RANGE: "LOCALHOST"}
    before = dict(os.environ)
    leave_out_own_endpoints()
    assert dict(os.environ) == before


@pytest.mark.parametrize("name", SETTLED_BY)
def test_whoever_has_settled_it_is_left_alone(bare: pytest.MonkeyPatch, name: str) -> None:
    """`rodless rig` changes nothing of an environment that says how far its nodes reach."""
    bare.setenv(name, "SUBNET")
    before = dict(os.environ)
    stay_on_this_machine()
    assert dict(os.environ) == before


def bound_to(pid: int) -> set[str]:
    """Return the addresses that the UDP sockets of a process are bound to, as the kernel has it."""
    links = []
    for link in Path(f"/proc/{pid}/fd").iterdir():
        with suppress(OSError):  # one that is closed meanwhile
            links.append(str(link.readlink()))
    inodes = {link[len("socket:[") : -1] for link in links if link.startswith("socket:[")}
    found = set()
    for table, size in (("udp", 8), ("udp6", 32)):
        for line in Path(f"/proc/{pid}/net/{table}").read_text(encoding="ascii").splitlines()[1:]:
            fields = line.split()
            if fields[9] in inodes:
                address = fields[1].partition(":")[0]
                assert len(address) == size
                found.add(".".join(str(byte) for byte in reversed(bytes.fromhex(address))))
    return found


@pytest.fixture
def rig_on_its_own(start_process: StartProcess) -> Iterator[int]:
    """Run `rodless rig` where nobody has settled how far it reaches; return its process group."""
    command = "from rodless_lab.cli.main import main; main()"
    unsettled = dict.fromkeys(SETTLED_BY, "")
    with start_process([sys.executable, "-c", command, "rig"], "rig", environment=unsettled) as rig:
        until_it_says(rig, "ready: preset paper", FIRST_START)
        yield rig.pid
        rig.signal(signal.SIGINT)
        assert rig.wait() == 0


def children(pid: int) -> list[int]:
    """Return the processes that a process has started."""
    return [one.pid for one in psutil.Process(pid).children()]


def test_a_rig_listens_on_loopback_alone(rig_on_its_own: int) -> None:
    """The kernel's own list of the sockets of plant, controller and the verb itself."""
    addresses = {pid: bound_to(pid) for pid in [rig_on_its_own, *children(rig_on_its_own)]}
    talking = {pid: where for pid, where in addresses.items() if where}
    assert len(talking) >= 2, addresses
    assert set().union(*talking.values()) == {LOOPBACK}
