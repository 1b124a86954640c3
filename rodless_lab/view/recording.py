# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A recorder beside the view, in a process of its own: its work must not slow the pages."""

import sys
import tempfile
import threading
from collections.abc import Sequence
from pathlib import Path

from rodless_base.topics import REFERENCE, RIG_CLOCK, RIG_TOPICS, ROS_CLOCK
from rodless_lab.session.processes import SessionProcesses
from rodless_lab.view.errors import ViewError

# What closing a bag may take, in wall-clock s.
CLOSE_TIMEOUT = 30.0

_NAME = "recorder"
_START = "from rodless_lab.cli.entry import main; main()"


class Recording:
    """One bag under way."""

    def __init__(self, path: Path, namespace: str) -> None:
        """Begin a bag at ``path`` of the rig in ``namespace``."""
        self.path = path
        self._stopping = threading.Lock()
        self._folder = tempfile.TemporaryDirectory(prefix="rodless_sim-")
        self._processes = SessionProcesses(
            {_NAME: command(path, namespace)},
            output=Path(self._folder.name),
            stop_timeout=CLOSE_TIMEOUT,
        )
        self._processes.__enter__()

    @property
    def problem(self) -> str | None:
        """Why nothing is recorded any more."""
        if not self._processes[_NAME].has_died:
            return None
        return f"{self.path.name}: {self._last_words()}"

    def stop(self) -> str:
        """Close the bag; return what is in it. Raises :class:`ViewError` for one not whole."""
        with self._stopping:
            died = self._processes[_NAME].has_died
            code = self._processes.stop()[_NAME]
            words = self._last_words()
            self._folder.cleanup()
        if died or code != 0:
            raise ViewError(f"{self.path.name}: {words}")
        return words

    def _last_words(self) -> str:
        """What the recorder has said at its end: how much there is, and what is missing of it."""
        lines = self._processes[_NAME].output.splitlines()
        ends = [place for place, line in enumerate(lines) if " messages in " in line]
        said = lines[ends[-1] :] if ends else lines[-1:]
        return "; ".join(said) or f"ended with exit code {self._processes.exit_codes[_NAME]}"


def command(path: Path, namespace: str) -> Sequence[str]:
    """Return the command line of a recorder of the rig's topics and its reference."""
    inside = namespace.rstrip("/")
    topics = [f"{inside}/{topic}" for topic in (*RIG_TOPICS, REFERENCE)]
    # The plant time of a rig in a namespace is on a clock of its own.
    clock = ["--ros-args", "-r", f"{ROS_CLOCK}:={inside}/{RIG_CLOCK}"] if inside else []
    return [sys.executable, "-c", _START, "record", "-o", str(path), *topics, *clock]
