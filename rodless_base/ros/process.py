# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Run one node in one process until it is asked to stop."""

import faulthandler
import gc
import shlex
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from io import UnsupportedOperation
from time import monotonic
from typing import Protocol

import rclpy
from rclpy.context import Context
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.logging import get_logger
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future

from rodless_base.command_line import Parser
from rodless_base.one_line import described
from rodless_base.parameters import ParameterError
from rodless_base.ros.diagnostics import steady_clock
from rodless_base.ros.guarded_node import GuardedNode
from rodless_base.ros.in_process import DirectDelivery, deliver_directly
from rodless_base.ros.publish import END_TIMEOUT
from rodless_base.start import STANDARD_ERROR, Stop, StoppedError, split_ros_arguments

# How often to look for a request to stop, in wall-clock s.
SPIN_SECONDS = 0.1

# Wall-clock s, from when nodes begin to end, to when their process ends even if the middleware does
# not let them: many times what they take on a busy machine.
END_ANYWAY = 20.0


class RunningNode(Protocol):
    """Something around a node that may do work of its own until ``close``.

    It has a node rather than being one: rclpy's Node keeps its own state under short private
    names (``_parameters``, ``_clock``), which a subclass would overwrite.
    """

    node: GuardedNode

    def close(self) -> None:
        """Stop that work and destroy the node."""


def make_executor(context: Context | None = None) -> Executor:
    """Return the events executor, a quarter of the cost of the default one, where there is one."""
    try:
        from rclpy.experimental import EventsExecutor  # noqa: PLC0415  absent before jazzy

        return EventsExecutor(context=context)
    except (ImportError, UnsupportedOperation, RuntimeError):
        # It wants the file descriptor of stderr, which pytest with --capture=sys has hidden, and
        # which is not there where it was closed.
        return SingleThreadedExecutor(context=context)


def spin(executor: Executor, stop: Stop, nodes: Sequence[GuardedNode] = ()) -> None:
    """Run callbacks until ``stop`` is requested, or a callback raises KeyboardInterrupt.

    All of ``nodes`` are told what else comes out of the executor: a message that it cannot read
    belongs to none of their callbacks.
    """
    over = None

    def end_if_asked() -> None:
        if stop.requested and over is not None:
            over.set_result(None)

    if nodes:
        # The events executor looks at its timeout only where it has nothing to do: never, where a
        # stopped reader holds a publisher up.
        nodes[0].create_timer(SPIN_SECONDS, end_if_asked, clock=steady_clock())
    while not stop.requested:
        try:
            # Without a timeout the events executor of jazzy burns a core and runs nothing. A new
            # future each time: other executors leave a callback in it that nobody takes out again.
            over = Future()
            executor.spin_until_future_complete(over, SPIN_SECONDS)
        except KeyboardInterrupt:
            stop.requested = True
        except Exception as error:
            if not nodes:
                raise
            for node in nodes:
                node.take_error(error)


def _settle_memory() -> None:
    """Take what start-up left in memory, the compiler above all, out of the garbage collector.

    Walking it stops the process for more than 100 ms, every few seconds at 1 kHz.
    """
    gc.collect()
    gc.freeze()


def _direct_delivery() -> DirectDelivery | None:
    delivery = deliver_directly(rclpy.get_default_context())
    if delivery is None:
        get_logger("rig").debug(
            "the nodes of this process deliver to each other through the middleware: direct "
            "delivery, which is faster, needs Fast DDS with fastdds.ignore_local_endpoints"
        )
    return delivery


def leave_ros() -> None:
    """Shut the default context down and let the signals be.

    From kilted on rclpy.try_shutdown takes "its" signal handlers away, whoever's they are: a second
    Ctrl-C would then kill the process on its way out.
    """
    rclpy.get_default_context().try_shutdown()


def check_arguments(node: str) -> None:
    """End the program where a node is given arguments that ROS does not read: they did nothing."""
    parser = Parser(
        prog=node,
        description=f"The {node} of a pneumatic servo rig, a node of ROS 2.",
        usage=f"{node} [-h] [--ros-args [-p NAME:=VALUE] [--params-file FILE] [-r FROM:=TO] ...]",
    )
    own, _ = split_ros_arguments(sys.argv[1:])
    _, others = parser.parse_known_args(own)
    if others:
        parser.error(
            f"{shlex.join(others)} refused: parameters, files and remappings follow --ros-args"
        )


def run_node(make_running: Callable[[], RunningNode], stop: Stop) -> int:
    """Build a node, run it until ``stop``, close it; return the exit code.

    Arguments that ROS cannot read, and a :class:`ParameterError`, are printed and give 1.
    """
    return run_nodes([make_running], stop)


def _made(make: Callable[[], RunningNode]) -> RunningNode:
    """Return what ``make`` makes; what middleware or machine have against it is a refusal, too."""
    try:
        return make()
    except (rclpy_implementation.RCLError, OSError) as error:
        raise ParameterError(described(error)) from error


@contextmanager
def _ended_anyway(seconds: float | None) -> Iterator[None]:
    """End the process with 1, and show where it stands, if the block takes longer; None: never.

    By a thread that no call into the middleware holds up. Shared memory may be left half written
    then, as where a user who has waited for so long kills the process.
    """
    if seconds is None:
        yield
        return
    faulthandler.dump_traceback_later(seconds, exit=True, file=STANDARD_ERROR)
    try:
        yield
    finally:
        faulthandler.cancel_dump_traceback_later()


def run_nodes(
    makers: Sequence[Callable[[], RunningNode]],
    stop: Stop,
    end_anyway: float | None = END_ANYWAY,
) -> int:
    """:func:`run_node` for several nodes in one executor.

    They deliver to each other directly where the middleware can be kept from doing so. A process
    that does not come to its end ends with 1 ``end_anyway`` s after its nodes began to, and shows
    where it stands; None for nodes whose end takes what it takes, as that of a bag.
    """
    # From here on an end on the spot would leave DDS's shared memory half written, and the next
    # process that opens it would wait for ever.
    stop.from_now_on_wait()
    try:
        rclpy.init(args=sys.argv, signal_handler_options=SignalHandlerOptions.NO)
    except (RuntimeError, UnicodeEncodeError) as error:
        print(f"refused to start: {type(error).__name__}: {error}", file=sys.stderr)
        return 1
    running: list[RunningNode] = []
    try:
        delivery = _direct_delivery() if len(makers) > 1 else None
        for make in makers:
            running.append(_made(make))
        _settle_memory()
        executor = make_executor()
        if delivery is not None:
            delivery.attach(executor, stop)
        for member in running:
            executor.add_node(member.node)
        try:
            spin(executor, stop, [member.node for member in running])
        finally:
            for member in running:
                executor.remove_node(member.node)
    except ParameterError as error:
        print(f"refused to start: {error}", file=sys.stderr)
        return 1
    except StoppedError:
        return 0
    finally:
        with _ended_anyway(end_anyway):
            deadline = monotonic() + END_TIMEOUT
            for member in running:
                member.node.end_by = deadline
            for member in reversed(running):
                member.close()
            leave_ros()
    return 0
