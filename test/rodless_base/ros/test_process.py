# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""How a node's process waits."""

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
