# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""How a node's process waits."""

import subprocess
import sys
from typing import cast

import pytest
from rclpy.context import Context
from rclpy.executors import Executor
from rclpy.task import Future

from rodless_base.ros.process import SPIN_SECONDS, make_executor, spin
from rodless_base.start import Stop


def test_waiting_leaves_nothing_behind() -> None:
    """Each spin waits for a future of its own, with a bound, until the process is to stop.

    Executors other than the events executor leave a callback in the future at each spin: one
    future for all spins would grow for as long as the node runs.
    """

    class FiveTurns:
        """An executor that asks the process to stop at its fifth spin."""

        def spin_until_future_complete(self, future: Future, timeout: float) -> None:
            """Note what is waited for."""
            futures.append(future)
            timeouts.add(timeout)
            stop.requested = len(futures) == 5

    class Requested:
        """A Stop that handles no signals."""

        requested = False

    futures: list[Future] = []
    timeouts: set[float] = set()
    stop = Requested()
    spin(cast(Executor, FiveTurns()), cast(Stop, stop))
    assert len({id(future) for future in futures}) == 5
    assert timeouts == {SPIN_SECONDS}


def test_an_executor_is_made_without_a_stream_of_errors(monkeypatch: pytest.MonkeyPatch) -> None:
    """A program whose stderr was closed (``2>&-``) has none; the events executor wants one."""
    monkeypatch.setattr(sys, "stderr", None)
    context = Context()
    context.init(args=[])
    try:
        make_executor(context).shutdown()
    finally:
        context.try_shutdown()


# A node whose end does not come back from C, with the lock of the interpreter in its hands.
HELD = """
import ctypes
from rodless_base.ros import process
from rodless_base.ros.guarded_node import GuardedNode
from rodless_base.start import Stop

class Held:
    def __init__(self):
        self.node = GuardedNode("held")
    def close(self):
        print("closing", flush=True)
        ctypes.PyDLL(None).sleep(60)

stop = Stop()
stop.requested = True
process.run_nodes([Held], stop, end_anyway=0.5)
"""


def test_a_process_that_the_middleware_holds_ends_all_the_same(domain: dict[str, str]) -> None:
    """With 1, and with the line in which it stands."""
    held = subprocess.run(
        [sys.executable, "-c", HELD],
        check=False,
        env=domain,
        capture_output=True,
        text=True,
        timeout=30,
    )
    assert held.stdout == "closing\n"
    assert held.returncode == 1
    assert "in close" in held.stderr
