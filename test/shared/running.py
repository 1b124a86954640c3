# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What fixtures that run processes return, and waiting for what a process prints."""

import threading
import time
from collections.abc import Callable
from contextlib import AbstractContextManager

from rodless_lab.session.node_process import NodeProcess
from rodless_lab.session.observer import TIMEOUT
from rodless_lab.session.processes import SessionProcesses
from rodless_lab.session.session import RigSession

# What the fixtures start_process, rodless, start_node; start_rig; rig_session return.
StartProcess = Callable[..., AbstractContextManager[NodeProcess]]
StartRig = Callable[..., AbstractContextManager[SessionProcesses]]
StartSession = Callable[..., RigSession]


def until_it_says(process: NodeProcess, text: str, timeout: float = TIMEOUT) -> None:
    """Wait until the output of ``process`` holds ``text``."""
    poll = threading.Event()
    deadline = time.monotonic() + timeout
    while text not in process.output:
        assert time.monotonic() < deadline, f"no {text!r} in:\n{process.output}"
        poll.wait(0.005)
