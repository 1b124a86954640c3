# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Start a ROS executable so that a signal to stop ends it cleanly from its first moment."""

import atexit
import importlib.util
import os
import signal
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from types import FrameType
from typing import NoReturn

from rodless_base.atomic_write import remove_unfinished
from rodless_base.output import Output
from rodless_base.ros.shared_memory import prepare_shared_memory

# What to say where there is no ROS.
NO_ROS = (
    "rclpy is missing: source a ROS 2 distribution, or install the wheels that "
    "`pip install rodless_sim` brings"
)

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

STANDARD_ERROR = 2

# A request after so long is another one: `ros2 launch` and a terminal may deliver one twice.
AGAIN_SECONDS = 0.5
ONCE_MORE = "\nending with what is under way; Ctrl-C once more ends it at once\n"


class StoppedError(Exception):
    """A request to stop came while something took long that a process needs before it runs."""


class Stop:
    """Whether the process has been asked to stop.

    Until :meth:`from_now_on_wait` is called, a request ends the process on the spot with exit
    code 0, or as :meth:`end_with` says: nothing runs yet, and importing and compiling take seconds.
    From then on it sets ``requested``, however often it comes (``ros2 launch`` delivers SIGINT
    twice).
    """

    def __init__(self, code: int = 0, line: str = "") -> None:
        """Handle signals from now on, those that our executables have kept waiting first."""
        self.requested = False
        # What takes back what a process would leave that ends on the spot.
        self.undo: Callable[[], object] = lambda: None
        # What is to happen at the first request, once the program ends itself.
        self.asked: Callable[[], object] = lambda: None
        self._running = self._impatient = False
        self._asked_at = 0.0
        self.end_with(code, line)
        for number in SIGNALS:
            # nohup has one ignored, for what is to go on when its terminal closes.
            if number != signal.SIGHUP or signal.getsignal(number) != signal.SIG_IGN:
                signal.signal(number, self._handle)
        # On its way out Python gives signals back their deadly default, unless they are ignored.
        atexit.register(self._ignore_from_now_on)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)

    def end_with(self, code: int, line: str = "") -> None:
        """Let a request end the process with this exit code, after a line on standard error."""
        self._code, self._line = code, f"{line}\n" if line else ""

    def from_now_on_wait(self, impatient: bool = False) -> None:
        """Let the program end itself; requests only set ``requested``.

        Where it may take a minute until it looks, as for the compiler, and has nothing to lose, let
        a user be ``impatient``: a second request ends the process on the spot after all.
        """
        self._running, self._impatient = True, impatient

    def _handle(self, _number: int, _frame: FrameType | None) -> None:
        first, self.requested = not self.requested, True
        if not self._running:
            self._end()
        if first:
            self.asked()
        if not self._impatient:
            return
        if first:
            self._asked_at = time.monotonic()
            _say(ONCE_MORE)
        elif time.monotonic() > self._asked_at + AGAIN_SECONDS:
            self._end()

    def _end(self) -> NoReturn:
        """End the process: an exception would get lost, or changed, in compiled code."""
        _say(self._line)
        remove_unfinished()
        with suppress(OSError):
            self.undo()
        os._exit(self._code)

    @staticmethod
    def _ignore_from_now_on() -> None:
        # A request that comes in the midst of this would be printed as an error nobody can catch.
        sys.unraisablehook = lambda _unraisable: None
        for number in (*SIGNALS, signal.SIGALRM):  # as of a timer that still runs
            signal.signal(number, signal.SIG_IGN)


def _say(line: str) -> None:
    with suppress(OSError):
        os.write(STANDARD_ERROR, line.encode())


def split_ros_arguments(arguments: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the arguments for others and those for ROS, from ``--ros-args`` to ``--``.

    Examples
    --------
    >>> split_ros_arguments(["run1", "--ros-args", "-r", "__ns:=/left", "--", "-o", "bag"])
    (['run1', '-o', 'bag'], ['-r', '__ns:=/left'])
    """
    own: list[str] = []
    for_ros: list[str] = []
    now = own
    for argument in arguments:
        if argument == "--ros-args":
            now = for_ros
        elif argument == "--" and now is for_ros:
            now = own
        else:
            now.append(argument)
    return own, for_ros


def start(module: str) -> None:
    """Call ``main(stop)`` of ``module`` and exit with what it returns."""
    Output()
    stop = Stop()
    try:
        note = prepare_shared_memory()
    except RuntimeError as error:
        sys.exit(f"refused to start: {error}")
    if note is not None:
        print(note, file=sys.stderr)
    try:
        main = importlib.import_module(module).main
    except ModuleNotFoundError:
        # Whichever ROS package came first, without rclpy there is no ROS.
        if importlib.util.find_spec("rclpy") is not None:
            raise
        sys.exit(NO_ROS)
    sys.exit(main(stop))


if __name__ == "__main__":
    start(sys.argv.pop(1))
