# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""ROS domains of one's own: never shared, never left behind."""

import errno
import os
import re
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest
from rclpy.exceptions import InvalidNamespaceException
from rclpy.validate_full_topic_name import validate_full_topic_name
from rclpy.validate_namespace import validate_namespace

from rodless_lab.session import domain as domain_module
from rodless_lab.session.domain import (
    DOMAINS,
    LONGEST_NAMESPACE,
    full_namespace,
    named_domain,
    own_domain,
)
from rodless_lab.session.errors import HarnessError
from rodless_lab.session.observer import Observer

HOLD = """
import sys
from rodless_lab.session import domain
domain.LOOPBACK = sys.argv[1]
with domain.own_domain() as environment:
    print(environment["ROS_DOMAIN_ID"], flush=True)
    sys.stdin.readline()
"""

NODE = """
import rclpy
rclpy.init()
rclpy.create_node("quiet").destroy_node()
rclpy.shutdown()
"""


@pytest.fixture(autouse=True)
def own_claims(monkeypatch: pytest.MonkeyPatch) -> None:
    """Keep the claims of these tests apart from those of real runs on this machine.

    All of 127.0.0.0/8 is loopback; this address is of this process.
    """
    number = os.getpid()
    address = f"127.{1 + (number >> 16) % 254}.{(number >> 8) & 255}.{number & 255}"
    monkeypatch.setattr(domain_module, "LOOPBACK", address)


@contextmanager
def other_process() -> Iterator[tuple[subprocess.Popen[str], int]]:
    """Another process that holds a domain, and which."""
    process = subprocess.Popen(
        [sys.executable, "-c", HOLD, domain_module.LOOPBACK],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    try:
        yield process, int(process.stdout.readline())
    finally:
        process.kill()
        process.communicate()


def claimed(environment: dict[str, str]) -> int:
    """The domain of an environment."""
    return int(environment["ROS_DOMAIN_ID"])


@pytest.mark.ros
@pytest.mark.parametrize("kind", ["", "_udp", "_anywhere", "_one_process", "_one_process_here"])
def test_a_domain_comes_with_what_keeps_it_on_this_machine(kind: str) -> None:
    """The environment names the domain and a profile, and DDS understands all of its kind."""
    with own_domain() as environment:
        assert claimed(environment) in DOMAINS
        ((name, value),) = (pair for pair in environment.items() if "PROFILES" in pair[0])
        profile = Path(value)
        assert profile.is_file()
        other = profile.with_name(profile.name.replace(".xml", f"{kind}.xml"))
        assert other.is_file()
        node = subprocess.run(
            [sys.executable, "-c", NODE],
            env={**os.environ, **environment, name: str(other)},
            capture_output=True,
            text=True,
            check=True,
        )
        assert node.stdout + node.stderr == ""


@pytest.mark.ros
def test_settings_that_dds_does_not_understand_would_be_seen(tmp_path: Path) -> None:
    """With a setting misspelt, the same node complains, which the test above would notice."""
    with own_domain() as environment:
        name, value = next(pair for pair in environment.items() if "PROFILES" in pair[0])
        bad = tmp_path / "bad.xml"
        bad.write_text(re.sub("heartbeat_?[pP]eriod", "heartbeatperiod", Path(value).read_text()))
        node = subprocess.run(
            [sys.executable, "-c", NODE],
            env={**os.environ, **environment, name: str(bad)},
            capture_output=True,
            text=True,
            check=True,
        )
        assert "heartbeatperiod" in node.stdout + node.stderr


def test_domains_stay_off_the_default_and_the_ephemeral_ports() -> None:
    """UDP ports of a domain start at 7400 + 250·domain; those from 32768 on are Linux's own."""
    assert 0 not in DOMAINS
    # The last port of the first participants: 7400 + 250·d + 11 + 2·p.
    assert 7400 + 250 * max(DOMAINS) + 11 + 2 * 50 < 32768


def test_two_claims_in_one_process_differ() -> None:
    """Nested or side by side, each block has a domain of its own."""
    with own_domain() as one, own_domain() as two, own_domain() as three:
        assert len({claimed(one), claimed(two), claimed(three)}) == 3


def test_claims_of_two_processes_differ() -> None:
    """Test runs side by side do not hear each other."""
    with other_process() as (_, theirs), own_domain() as ours:
        assert claimed(ours) != theirs


def test_a_claim_ends_with_its_block() -> None:
    """Its domain is the first to be given again, also after an error inside the block."""
    with own_domain() as first:
        pass
    with pytest.raises(KeyError), own_domain():
        raise KeyError
    with own_domain() as second:
        assert claimed(second) == claimed(first)


def test_a_killed_process_leaves_no_claim() -> None:
    """The kernel drops the lock: the domain is free again without any tidying up."""
    with other_process() as (process, theirs):
        process.kill()
        process.wait()
        with own_domain() as ours:
            assert claimed(ours) == theirs


def test_when_all_are_taken_it_says_so() -> None:
    """The 102nd claim is refused with the range in the message; one given back can be taken."""
    with ExitStack() as stack:
        taken = {claimed(stack.enter_context(own_domain())) for _ in DOMAINS}
        assert taken == set(range(1, 102))
        with pytest.raises(RuntimeError, match="all ROS domains 1-101 are in use"):
            stack.enter_context(own_domain())
    with own_domain() as environment:
        assert claimed(environment) == 1


def test_a_claim_is_of_the_machine_and_needs_no_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whoever holds the domain's port has it: a process of another user and another home too."""
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setenv("HOME", str(tmp_path))
    with socket.socket() as somebody:
        somebody.bind((domain_module.LOOPBACK, 7400 + 250 * 1 + 5))
        with own_domain() as environment:
            assert claimed(environment) == 2
    assert list(tmp_path.iterdir()) == []


@pytest.mark.ros
def test_the_claimed_port_is_none_of_dds(domain: dict[str, str]) -> None:
    """A node in a claimed domain starts beside the claim, on the ports of its participant."""
    number = int(domain["ROS_DOMAIN_ID"])
    done = subprocess.run(
        [sys.executable, "-c", NODE], env=domain, capture_output=True, text=True, check=True
    )
    assert done.stdout + done.stderr == ""
    first = 7400 + 250 * number
    of_dds = {first, first + 1} | {first + 10 + 2 * p + k for p in range(119) for k in (0, 1)}
    assert first + 5 not in of_dds
    assert max(of_dds) < first + 250


def test_a_claim_cannot_be_connected_to_nor_inherited() -> None:
    """It listens to nobody, and a child process that outlives the block does not keep it."""
    with own_domain() as environment:
        port = 7400 + 250 * claimed(environment) + 5
        with socket.socket() as stranger:
            assert stranger.connect_ex((domain_module.LOOPBACK, port)) == errno.ECONNREFUSED
        child = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)
    with own_domain() as again:
        assert claimed(again) == claimed(environment)
    child.communicate(b"\n")


def test_without_loopback_it_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    """In one line with the address, and not as if all domains were taken."""
    monkeypatch.setattr(domain_module, "LOOPBACK", "192.0.2.1")
    with (
        pytest.raises(HarnessError, match=r"^192\.0\.2\.1 port 7655: cannot be claimed"),
        own_domain(),
    ):
        pass


@pytest.mark.parametrize(("text", "domain"), [("", None), ("0", 0), ("232", 232)])
def test_the_domain_of_the_environment(
    monkeypatch: pytest.MonkeyPatch, text: str, domain: int | None
) -> None:
    """From 0 to the greatest; an empty text is the default, as for ROS."""
    monkeypatch.setenv("ROS_DOMAIN_ID", text)
    assert named_domain() == domain


def test_an_environment_in_which_nobody_is_found_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nodes would wait for each other for ever."""
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF")
    with pytest.raises(HarnessError, match="_DISCOVERY_RANGE=OFF: nodes find nobody"):
        Observer()
    with own_domain() as environment:
        Observer(environment).close()


@pytest.mark.parametrize("text", ["abc", "999", "233", "-1", "1.5", " ", "²"])
def test_a_domain_that_does_not_exist_is_named(monkeypatch: pytest.MonkeyPatch, text: str) -> None:
    """With the range, in one line."""
    monkeypatch.setenv("ROS_DOMAIN_ID", text)
    with pytest.raises(HarnessError) as refused:
        named_domain()
    assert str(refused.value) == f"ROS_DOMAIN_ID={text!r}: must be a whole number from 0 to 232"


@pytest.mark.parametrize(
    ("text", "full"),
    [("", "/"), ("/", "/"), ("a", "/a"), ("/a/_b2/", "/a/_b2"), ("cell/rig1", "/cell/rig1")],
)
def test_a_namespace_with_or_without_its_slash(text: str, full: str) -> None:
    """Both name the same."""
    assert full_namespace(text) == full


@pytest.mark.parametrize("text", ["a b", "1a", "/a/2", "a//b", "ä", "a-b", "a\n", "~a", "{ns}"])
def test_a_namespace_that_ros_refuses_is_named(text: str) -> None:
    """As rclpy refuses it, but in one line of our own."""
    with pytest.raises(InvalidNamespaceException):
        validate_namespace(f"/{text.strip('/')}")
    with pytest.raises(HarnessError, match="letters, digits, _ and / only"):
        full_namespace(text)


def test_a_namespace_leaves_room_for_the_longest_topic() -> None:
    """ROS takes names of 247 characters; what is longer is refused in a line that can be read."""
    longest = f"/{'a' * (LONGEST_NAMESPACE - 1)}"
    assert full_namespace(longest) == longest
    validate_full_topic_name(f"{longest}/controller/set_parameters_atomically")
    with pytest.raises(HarnessError, match="300 characters refused, must be at most 190") as line:
        full_namespace("b" * 300)
    assert len(str(line.value)) < 250
