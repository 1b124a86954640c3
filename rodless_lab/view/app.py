# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A view from its start to its end: rig, topics, pages."""

import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

from rodless_base.start import Stop
from rodless_lab.session.domain import full_namespace, named_domain
from rodless_lab.session.network import stay_on_this_machine
from rodless_lab.session.processes import ProcessPlan, SessionProcesses, run_rig
from rodless_lab.session.running_rig import RunningRig
from rodless_lab.view.errors import ViewError
from rodless_lab.view.origins import is_loopback
from rodless_lab.view.page import build
from rodless_lab.view.requests import Requests, open_playback
from rodless_lab.view.ros.desk import ANSWER_TIMEOUT, Desk
from rodless_lab.view.ros.live import LiveRig
from rodless_lab.view.server import Server
from rodless_lab.view.state import ViewState

# What Ctrl-C promises of the nodes, in wall-clock s.
STOP_TIMEOUT = 2.0

# How often the end is looked for where bags are shown alone, in wall-clock s.
POLL_SECONDS = 0.2


@dataclass(frozen=True)
class Options:
    """What `rodless view` is told."""

    bags: list[Path]
    namespace: str
    rig: bool
    preset: str
    host: str
    port: int
    folder: Path


def serve(options: Options, stop: Stop, say: Callable[[str], None]) -> None:
    """Serve pages until ``stop``; ``say`` where they are.

    Raises HarnessError, :class:`ViewError`, or NodeDiedError where a rig of its own ends.
    """
    if len(options.bags) > 2:
        raise ViewError("more than two bags: one can be shown, or two compared")
    if not options.folder.is_dir():
        raise ViewError(f"--folder {options.folder}: no such folder")
    namespace = full_namespace(options.namespace)
    named_domain()
    live = not options.bags or options.rig or bool(options.namespace)
    state = ViewState(namespace, live)
    if options.bags:
        state.playback = open_playback(options.bags)
    with ExitStack() as stack:
        if live:
            _serve_rig(options, state, stop, say, stack)
        else:
            requests = Requests(state, options.folder, None, None)
            server = _open(options, requests, say, stack)
            while not stop.requested:
                server.check()
                time.sleep(POLL_SECONDS)


def _serve_rig(
    options: Options, state: ViewState, stop: Stop, say: Callable[[str], None], stack: ExitStack
) -> None:
    processes: SessionProcesses | None = None
    if options.rig:
        stay_on_this_machine()
        plan = ProcessPlan(options.preset, namespace=options.namespace)
        with RunningRig(options.namespace, stop) as there:
            there.check_free(plan.own_nodes)
        processes = stack.enter_context(run_rig(plan, stop_timeout=STOP_TIMEOUT))
    rig = stack.enter_context(RunningRig(options.namespace, stop, ANSWER_TIMEOUT))
    desk = Desk(rig, state)
    live = stack.enter_context(LiveRig(rig.observer.context, state))
    requests = Requests(state, options.folder, live, desk)
    stack.callback(requests.close)
    server = _open(options, requests, say, stack)

    def check() -> None:
        server.check()
        if processes is not None:
            processes.check()

    desk.serve(stop, check)


def _open(
    options: Options, requests: Requests, say: Callable[[str], None], stack: ExitStack
) -> Server:
    server = Server(lambda: build(requests), options.host, options.port)
    stack.enter_context(server)
    if not is_loopback(options.host):
        say(f"{options.host} is not this machine alone: whoever reaches it can steer the rig")
    say(f"open {server.address} in a browser. Stop: Ctrl-C.")
    return server
