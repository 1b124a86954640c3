# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A process in a group of its own, its output kept or shown, never left behind."""

import contextlib
import os
import signal
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from rodless_base.forked import left_to_parent
from rodless_base.one_line import shown
from rodless_lab.session import guard
from rodless_lab.session.errors import HarnessError, WaitTimeoutError
from rodless_lab.session.opening_process import OpeningProcess

# Default bound of a wait, in wall-clock s.
TIMEOUT = 60.0

# From the request to stop to the end by force, in wall-clock s. The nodes promise to end within
# 2 s; a crowded machine may need longer.
STOP_TIMEOUT = 10.0

# A guard that ends what it still watches takes its own timeout, and a moment to read and to go.
CLOSE_TIMEOUT = 2.0 * guard.TIMEOUT


class Guard:
    """Another process, which ends those it is told of should this one be killed."""

    def __init__(self) -> None:
        """Start it with the first process to watch."""
        self._process: subprocess.Popen[str] | None = None
        left_to_parent(self)

    def leave_to_parent(self) -> None:
        """Let go: the guard waits for the end of what it is told by."""
        if self._process is not None:
            assert self._process.stdin is not None
            with contextlib.suppress(OSError):
                self._process.stdin.close()
            self._process = None

    def tell(self, word: str) -> None:
        """Say that a process has started (``+`` and its ID) or ended (``-``)."""
        if self._process is None and word.startswith("-"):
            return  # it was closed, and watches nobody
        if self._process is None:
            self._process = self._started()
        assert self._process.stdin is not None
        # A guard that somebody has killed must not fail a test.
        with contextlib.suppress(BrokenPipeError):
            self._process.stdin.write(f"{word}\n")
            self._process.stdin.flush()

    @staticmethod
    def _started() -> subprocess.Popen[str]:
        return subprocess.Popen(
            [sys.executable, "-I", "-S", guard.__file__],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
            text=True,
        )

    def close(self) -> None:
        """End it; whatever it still watches ends too, unless that takes longer than it may."""
        if self._process is None:
            return
        assert self._process.stdin is not None
        # Only what runs reads the end of its input.
        self._process.send_signal(signal.SIGCONT)
        with contextlib.suppress(BrokenPipeError):
            self._process.stdin.close()
        try:
            self._process.wait(CLOSE_TIMEOUT)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._process = None


class NodeProcess:
    """One process and whatever it starts; a process forked from the one that started it has none.

    There its methods raise HarnessError.
    """

    def __init__(
        self,
        name: str,
        command: Sequence[str],
        environment: Mapping[str, str],
        output: Path | None,
        guard: Guard,
    ) -> None:
        """Prepare ``command``; nothing starts yet.

        What it prints goes to the file ``output``, or with None where this process prints.
        """
        self.name = name
        self._command = list(command)
        self._environment = dict(environment)
        self._output = output
        self._guard = guard
        self._process: subprocess.Popen[bytes] | None = None
        self._opening = OpeningProcess()
        self._meant_to_run = False
        self._over = True
        self.is_frozen = False
        self.had_to_be_killed = False  # at least once, as it did not end when it was asked to
        self._printed_before = 0  # bytes of another session's, in the same file
        if output is not None:
            output.touch()
            self._printed_before = output.stat().st_size

    def start(self) -> None:
        """Start it; its output is appended to that of an earlier start."""
        with contextlib.ExitStack() as stack:
            output = stack.enter_context(self._output.open("ab")) if self._output else None
            try:
                self._process = subprocess.Popen(
                    self._command,
                    env=self._environment,
                    stdin=subprocess.DEVNULL,
                    stdout=output,
                    stderr=subprocess.STDOUT if output else None,
                    # Ctrl-C in a terminal is for this process, which then ends the nodes in order.
                    start_new_session=True,
                )
            except OSError as error:
                raise HarnessError(
                    f"{self.name}: {shown(self._command[0])} cannot be started: {error.strerror}"
                ) from error
        self._meant_to_run, self.is_frozen = True, False
        self._over = False
        self._guard.tell(f"+{self._process.pid}")

    @property
    def keeps_output(self) -> bool:
        """Whether what it prints is kept."""
        return self._output is not None

    @property
    def output(self) -> str:
        """What it has printed so far, on both streams; empty where that is not kept."""
        if self._output is None:
            return ""
        try:
            with self._output.open("rb") as file:
                file.seek(self._printed_before)
                return file.read().decode("utf-8", errors="replace")
        except OSError as error:  # what it was to explain is worth more than the loss of it
            return f"{self._output}: cannot be read: {error.strerror}\n"

    @property
    def pid(self) -> int:
        """Its process ID; raises HarnessError before the first start."""
        if self._process is None:
            raise HarnessError(f"the {self.name} has not been started")
        return self._process.pid

    @property
    def exit_code(self) -> int | None:
        """Its exit code, negative for a signal, or None while it runs."""
        if self._process is None:
            return None
        self._opening.check()
        if self._process.poll() is not None:
            self._end_what_it_left()
        return self._process.returncode

    @property
    def has_died(self) -> bool:
        """Whether it has ended without having been asked to."""
        return self._meant_to_run and self.exit_code is not None

    def signal(self, number: int) -> None:
        """Send a signal to it and all it has started, if it still runs."""
        if self.exit_code is None:
            # Not the process alone: `ros2 run`, for one, passes no signal on.
            self._signal_group(number)

    def freeze(self) -> None:
        """Hold it where it is; it answers nothing until :meth:`thaw`."""
        self.signal(signal.SIGSTOP)
        self.is_frozen = True

    def thaw(self) -> None:
        """Let it go on."""
        self.signal(signal.SIGCONT)
        self.is_frozen = False

    def kill(self) -> None:
        """End it at once."""
        self._meant_to_run = False
        self.signal(signal.SIGKILL)
        self._reap()

    def wait(self, timeout: float = TIMEOUT) -> int:
        """Wait until it has ended; return its exit code.

        Raises :class:`WaitTimeoutError`, with its output, if that takes longer than ``timeout``
        (wall-clock s).
        """
        assert self._process is not None
        self._opening.check()
        try:
            self._process.wait(timeout)
        except subprocess.TimeoutExpired as error:
            raise WaitTimeoutError(
                f"the {self.name} has not ended within {timeout:g} s\n{self.output}"
            ) from error
        self._meant_to_run = False
        self._reap()
        return int(self._process.returncode)

    def ask_to_stop(self) -> None:
        """Interrupt it, as Ctrl-C does."""
        self._meant_to_run = False
        if self._process is not None:
            self.thaw()
            self.signal(signal.SIGINT)

    def end(self, timeout: float = STOP_TIMEOUT) -> None:
        """Wait up to ``timeout`` (wall-clock s) for it to stop, then kill it."""
        if self._process is None:
            return
        self._opening.check()
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(timeout)
        self.had_to_be_killed |= self.exit_code is None
        self.signal(signal.SIGKILL)
        self._reap()

    def _reap(self) -> None:
        assert self._process is not None
        self._process.wait()
        self._end_what_it_left()

    def _end_what_it_left(self) -> None:
        """Kill what it has started and not ended, at once: its ID may soon be another's."""
        if not self._over:
            self._over = True
            self._signal_group(signal.SIGKILL)
            self._guard.tell(f"-{self.pid}")

    def _signal_group(self, number: int) -> None:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.pid, number)
