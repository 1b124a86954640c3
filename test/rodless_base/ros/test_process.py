"""How a node's process waits."""

from typing import cast

from rclpy.executors import Executor
from rclpy.task import Future

from rodless_base.ros.process import SPIN_SECONDS, spin
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
