# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The process that outlives a session to end its nodes: it never holds up the session itself."""

import contextlib
import os
import select
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from rodless_lab.session import node_process
from rodless_lab.session.node_process import Guard


def children() -> set[int]:
    """Return the process IDs of what this process has started and not yet waited for."""
    found = set()
    for task in Path("/proc/self/task").glob("*/children"):
        with contextlib.suppress(OSError):  # of a thread that has ended meanwhile
            found |= set(map(int, task.read_text().split()))
    return found


def waiting(action: str) -> list[str]:
    """Return the command of a process that takes SIGINT so, and says when it does."""
    program = f"import signal; signal.signal(2, signal.{action}); print(flush=True); signal.pause()"
    return [sys.executable, "-I", "-S", "-c", program]


@pytest.fixture(params=["SIG_DFL"])
def watched(request: pytest.FixtureRequest) -> Iterator[subprocess.Popen[bytes]]:
    """Return a process that leads a group of its own, as a node does."""
    command = waiting(request.param)
    with subprocess.Popen(command, stdout=subprocess.PIPE, start_new_session=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"\n"
        yield process
        process.kill()


def test_a_guard_that_was_stopped_still_ends_what_it_watches(
    watched: subprocess.Popen[bytes],
) -> None:
    """Somebody has sent it SIGSTOP: it is woken, does its work, and is waited for."""
    guard = Guard()
    before = children()
    guard.tell(f"+{watched.pid}")
    (pid,) = children() - before
    os.kill(pid, signal.SIGSTOP)
    guard.close()
    assert watched.wait(10.0) == -signal.SIGINT
    assert children() - before == set()


@pytest.mark.parametrize("watched", ["SIG_IGN"], indirect=True)
def test_a_guard_that_takes_too_long_is_not_waited_for(
    watched: subprocess.Popen[bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    """It gives what ignores SIGINT its full time, and a session that is to end has less here."""
    monkeypatch.setattr(node_process, "CLOSE_TIMEOUT", 0.1)
    guard = Guard()
    before = children()
    guard.tell(f"+{watched.pid}")
    guard.close()
    assert children() - before == set()
    assert watched.poll() is None


def test_a_guard_that_was_killed_is_not_missed(watched: subprocess.Popen[bytes]) -> None:
    """Words to it get lost and its end is no error: it had nothing to do while all went well."""
    guard = Guard()
    before = children()
    guard.tell(f"+{watched.pid}")
    (pid,) = children() - before
    os.kill(pid, signal.SIGKILL)
    os.waitid(os.P_PID, pid, os.WEXITED | os.WNOWAIT)
    guard.tell(f"-{watched.pid}")
    guard.close()
    assert watched.poll() is None


def test_a_group_whose_leader_has_gone_ends_too() -> None:
    """Only what it has started still runs, and nobody has told the guard of its end."""
    program = (
        "import os, signal, sys\n"
        "if os.fork(): os._exit(0)\n"
        "print(os.getpid(), flush=True)\n"
        "signal.pause()\n"
    )
    with subprocess.Popen(
        [sys.executable, "-I", "-S", "-c", program], stdout=subprocess.PIPE, start_new_session=True
    ) as leader:
        assert leader.stdout is not None
        left = int(leader.stdout.readline())
        leader.wait(10.0)
        with os.fdopen(os.pidfd_open(left)) as handle:
            guard = Guard()
            guard.tell(f"+{leader.pid}")
            guard.close()
            assert select.select([handle], [], [], 10.0)[0]


def test_a_guard_that_was_closed_is_not_started_for_the_end_of_a_process() -> None:
    """It would live as long as this one."""
    guard, before = Guard(), children()
    guard.tell("-1")
    assert children() == before
