"""One process, its output kept, which ends with the test whatever happens."""

import signal
import subprocess
import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from types import TracebackType

from observer import TIMEOUT

from rodless_lab.session.processes import RigProcesses

# What running processes have printed, by their name, so that a failing test can show it.
OUTPUTS: dict[str, Callable[[], str]] = {}


class NodeProcess:
    """A process between ``__enter__`` and ``__exit__``; what it prints comes as it prints it."""

    def __init__(self, command: Sequence[str], environment: Mapping[str, str]) -> None:
        """Prepare ``command``; nothing starts yet."""
        self.command = list(command)
        self._environment = dict(environment)
        self._said = threading.Condition()
        self._lines: list[str] = []

    def __enter__(self) -> "NodeProcess":
        self.process = subprocess.Popen(
            self.command,
            env=self._environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
        )
        OUTPUTS[" ".join(self.command)] = lambda: self.output
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()
        return self

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            with self._said:
                self._lines.append(line)
                self._said.notify_all()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self.process.poll() is None:
            self._stop()
        self._reader.join()
        OUTPUTS.pop(" ".join(self.command), None)

    def _stop(self) -> None:
        # Not killed at once: a killed process can leave shared memory that stops the next one.
        self.process.send_signal(signal.SIGINT)
        try:
            self.process.wait(10.0)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()

    @property
    def output(self) -> str:
        """What it has printed so far, on both streams."""
        with self._said:
            return "".join(self._lines)

    def until_it_says(self, text: str) -> None:
        """Wait until its output holds ``text``."""
        with self._said:
            found = self._said.wait_for(lambda: text in "".join(self._lines), TIMEOUT)
        assert found, f"waited in vain for {text!r} in:\n{self.output}"

    def end(self, timeout: float = TIMEOUT) -> int:
        """Wait until it has ended and all it printed has been read; return its exit code."""
        code = self.process.wait(timeout)
        self._reader.join(timeout)
        return code

    def signal(self, number: int) -> None:
        """Send a signal; one that has ended already takes none."""
        self.process.send_signal(number)


# What the fixtures of these names return.
StartNode = Callable[..., AbstractContextManager[NodeProcess]]
StartRig = Callable[..., AbstractContextManager[RigProcesses]]
