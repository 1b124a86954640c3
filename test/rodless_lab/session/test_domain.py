"""ROS domains of one's own: never shared, never left behind."""

import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest
from rclpy.exceptions import InvalidNamespaceException
from rclpy.validate_namespace import validate_namespace

from rodless_lab.session.domain import DOMAINS, full_namespace, named_domain, own_domain
from rodless_lab.session.errors import HarnessError

HOLD = """
import sys
from rodless_lab.session.domain import own_domain
with own_domain() as environment:
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
def own_locks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Keep the claims of these tests apart from those of real runs on this machine."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setenv("TMPDIR", str(tmp_path))


@contextmanager
def other_process() -> Iterator[tuple[subprocess.Popen[str], int]]:
    """Another process that holds a domain, and which."""
    process = subprocess.Popen(
        [sys.executable, "-c", HOLD], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
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
@pytest.mark.parametrize("kind", ["", "_udp", "_one_process", "_one_process_here"])
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


def test_lock_files_belong_to_their_user(tmp_path: Path) -> None:
    """Their names carry the user: nobody's lock file, closed to others, is in another's way."""
    with own_domain():
        assert [f"-{os.getuid()}-" in path.name for path in tmp_path.iterdir()] == [True]


@pytest.mark.parametrize(("text", "domain"), [("", None), ("0", 0), ("232", 232)])
def test_the_domain_of_the_environment(
    monkeypatch: pytest.MonkeyPatch, text: str, domain: int | None
) -> None:
    """From 0 to the greatest; an empty text is the default, as for ROS."""
    monkeypatch.setenv("ROS_DOMAIN_ID", text)
    assert named_domain() == domain


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
