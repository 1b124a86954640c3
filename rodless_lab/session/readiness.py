# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""When a rig that has been started is ready, and what its user can do then."""

from collections.abc import Callable, Sequence
from time import monotonic

from diagnostic_msgs.msg import DiagnosticStatus

from rodless_base.start import Stop
from rodless_base.topics import JOINT_STATES, VALVE_VOLTAGE
from rodless_lab.session.diagnostic import Diagnostic
from rodless_lab.session.observer import Observer
from rodless_lab.session.processes import ProcessPlan
from rodless_lab.session.running_rig import PLANT, RigError, RunningRig

# Wall-clock s after which a rig says why it does not work: that long while nothing changes in that,
# and longer while the plant is silent, which may compile for a minute or two and says so itself.
REPORT_SECONDS = 10.0
COMPILING_SECONDS = 180.0

NOT_FOUND = (
    "not found: it compiles for its first start, or the ROS_ and FASTDDS_ variables of the "
    "environment keep nodes from finding each other"
)


def say_when_ready(
    plan: ProcessPlan, stop: Stop, ended: Callable[[], bool], say: Callable[[str], None]
) -> None:
    """Call ``say`` with a line as soon as the nodes of ``plan`` work, unless ``ended`` before.

    A plant without a controller is ready once it reports. Where a node is there but is silent or
    does not work for a while, ``say`` is told why. Raises RigError where a node has a namesake: a
    rig of the same name, started at the same moment or found late.
    """
    with RunningRig(plan.namespace, stop) as rig:
        since, failing, said = monotonic(), "", ""
        while not ended():
            rig.observer.spin()
            if texts := list(filter(None, map(rig.namesakes, plan.own_nodes))):
                raise RigError(texts[0])
            before, failing = failing, "; ".join(_failing(plan.own_nodes, rig))
            plant = rig.diagnostic(PLANT)
            if plant is not None and (not failing or not plan.runs_controller_node):
                say(_ready_line(plan, rig.observer, plant))
                return
            if failing != before:
                since = monotonic()
            starting = plant is None or not all(map(rig.is_known, plan.own_nodes))
            patience = COMPILING_SECONDS if starting else REPORT_SECONDS
            if failing != said and monotonic() > since + patience:
                said = failing
                say(f"not ready: {failing}")


def _failing(nodes: Sequence[str], rig: RunningRig) -> list[str]:
    """Say of each node that is silent, or says itself that it does not work, which it is."""
    reports = {node: rig.diagnostic(node) for node in nodes}
    return [
        f"{rig.name(node)}: {rig.state_of(node) if said or rig.is_known(node) else NOT_FOUND}"
        for node, said in reports.items()
        if said is None or rig.is_silent(node) or said.level == DiagnosticStatus.ERROR
    ]


def _ready_line(plan: ProcessPlan, observer: Observer, plant: Diagnostic) -> str:
    lockstep = plant.values.get("mode") == "lockstep"
    mode = "lock-step" if lockstep else "real time"
    return (
        f"ready: preset {plan.preset}, {mode}. {_next_step(plan, observer, lockstep)}. "
        f"State: {_command('status', observer)}. Stop: Ctrl-C."
    )


def _next_step(plan: ProcessPlan, observer: Observer, lockstep: bool) -> str:
    samples, commands = map(observer.node.resolve_topic_name, (JOINT_STATES, VALVE_VOLTAGE))
    if plan.runs_controller_node:
        return f"Move: {_command('move 58', observer)}"
    if lockstep:
        return f"Waiting for a subscriber to {samples} and one publisher on {commands}"
    return f"Commands are expected on {commands}"


def _command(verb: str, observer: Observer) -> str:
    """Return the command line of ``verb`` for the rig in the namespace of ``observer``."""
    namespace = observer.node.get_namespace()
    return f"rodless {verb}" + ("" if namespace == "/" else f" --namespace {namespace}")
