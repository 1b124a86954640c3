# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A rig that runs already: its nodes found, in the domain and namespace that the user names."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from time import monotonic

from diagnostic_msgs.msg import DiagnosticStatus

from rodless_base.closing import Closing
from rodless_base.ros.diagnostics import COMMANDED_BY, NAMESAKES
from rodless_base.ros.namesakes import count_nodes, namesakes_text
from rodless_base.ros.rivals import publishers_of, rivals_text
from rodless_base.ros.unheard import WAY_OUT, has_unheard_publisher
from rodless_base.start import Stop
from rodless_base.topics import JOINT_STATES, VALVE_VOLTAGE
from rodless_lab.session.diagnostic import Diagnostic, count_among
from rodless_lab.session.domain import full_namespace
from rodless_lab.session.errors import HarnessError, InterruptedRunError, WaitTimeoutError
from rodless_lab.session.observer import TIMEOUT, Observer

NODES = PLANT, CONTROLLER = "plant", "controller"

# How long to wait for the second node once the first is there, in s: Fast DDS may take 3 s.
OTHER_NODE_TIMEOUT = 5.0

# In which time whoever is in a domain is discovered, in wall-clock s: Fast DDS takes up to 2.9.
# It is waited for where a node does not report its namesakes, and before a rig is started.
DISCOVERY = 3.0

# For the name of a node whose topics are known, in wall-clock s: they come together, or nearly.
NAME_TIMEOUT = 2.0

# Nodes report once a second: one that has not for so long, in wall-clock s, is silent.
SILENCE = 3.0

# Why a node is not found although the other one is.
ABSENT = "it was not started, compiles still, has ended or is frozen"

# Why a node says nothing any more. One that was killed is known for up to 20 s.
# The plant runs no law but where both share a process, and then both are silent.
_LAW = "held up by a law that does not return, "
SILENT = {
    node: f"silent: compiling for its first start, {law}killed, frozen, or its machine is too busy"
    for node, law in ((PLANT, ""), (CONTROLLER, _LAW))
}


def is_silent(said: Diagnostic | None) -> bool:
    """Whether a node whose last report is ``said`` has not reported for a while, or not at all."""
    return said is None or monotonic() - said.arrived > SILENCE


class RigError(HarnessError):
    """What was asked of a running rig cannot be done; the text says why, in one line."""


class RunningRig(Closing):
    """Plant and controller of one namespace, which somebody else has started.

    Waiting raises :class:`InterruptedRunError` as soon as ``stop`` is requested.
    """

    def __init__(self, namespace: str, stop: Stop, timeout: float = TIMEOUT) -> None:
        """Join the domain that the environment names; raises HarnessError for one it cannot.

        ``timeout`` (wall-clock s) bounds each wait for an answer.
        """
        self.namespace = full_namespace(namespace)
        self._stop = stop
        self._may_stop = True
        self._joined = monotonic()
        self.observer = Observer(namespace=self.namespace, timeout=timeout, check=self._check)
        # Asked for now, so that what the nodes say once a second is not missed.
        self._diagnostics = self.observer.diagnostics

    def close(self) -> None:
        """Leave the domain; the rig keeps running."""
        self.observer.close()

    def _check(self) -> None:
        if self._stop.requested and self._may_stop:
            raise InterruptedRunError

    @contextmanager
    def uninterrupted(self) -> Iterator[None]:
        """Let a request to stop wait for the end of the block."""
        self._may_stop = False
        try:
            yield
        finally:
            self._may_stop = True

    def name(self, relative: str) -> str:
        """Return the full name of a topic or node."""
        return str(self.observer.node.resolve_topic_name(relative))

    def wait_for(self, condition: Callable[[], object], timeout: float) -> bool:
        """Wait until ``condition()`` is true; return whether it was within ``timeout`` s."""
        try:
            self.observer.wait(condition, "", timeout)
        except WaitTimeoutError:
            return False
        return True

    def is_known(self, node: str) -> bool:
        """Whether ``node`` is known in this namespace."""
        return (node, self.namespace) in self._nodes()

    def is_unheard(self) -> bool:
        """Whether a plant is there of which nothing arrives."""
        return has_unheard_publisher(self.observer.node, self.name(JOINT_STATES))

    def samples_elsewhere(self) -> str | None:
        """Say that the plant runs and nobody publishes its samples where they belong, if so."""
        topic = self.name(JOINT_STATES)
        if self.is_silent(PLANT) or self.observer.node.count_publishers(topic):
            return None
        return (
            f"nobody publishes {topic}, and the plant runs: its samples go elsewhere; start it "
            f"without a remapping of {JOINT_STATES}"
        )

    def check_free(self, nodes: Sequence[str]) -> None:
        """Raise :class:`RigError` where one of ``nodes`` runs already.

        Each would disturb the other. One that starts at the same moment, or is found late, ends
        the new rig while it gets ready.
        """
        self.wait_for(lambda: any(map(self.is_known, nodes)), DISCOVERY)
        # A name may come after what its node publishes.
        self.wait_for(lambda: not self.is_unheard(), NAME_TIMEOUT)
        found = next(filter(self.is_known, nodes), None)
        domain = self.observer.context.get_domain_id()
        where = f"in namespace {self.namespace} of ROS domain {domain}"
        way_out = "stop that rig, or give this one a --namespace of its own"
        if found is not None:
            raise RigError(f"a {found} runs already {where}: {way_out}")
        if self.is_unheard():
            raise RigError(f"a plant runs already {where}, of which nothing arrives: {way_out}")

    def wait_for_node(self, node: str, timeout: float) -> None:
        """Wait for ``node`` to appear; raises :class:`RigError` saying where there is one."""
        if not self.wait_for(lambda: self.is_known(node), timeout):
            raise RigError(self.missing(node, timeout))

    def check_alone(self) -> None:
        """Raise :class:`RigError` where a node of the rig has a namesake here."""
        for text in self.doubles():
            raise RigError(text)

    def doubles(self) -> list[str]:
        """Say which nodes of the rig have namesakes here, as where two rigs have one name.

        Each node knows its own and reports them. Where one does not, whoever is here is found by
        listening. A namesake that has only just started may be missed.
        """
        rest = self._joined + DISCOVERY - monotonic()
        self.wait_for(self._namesakes_are_known, max(rest, 0.0))
        return [text for node in NODES if (text := self.namesakes(node))]

    def _namesakes_are_known(self) -> bool:
        reported = all(self._reported_namesakes(node) for node in NODES)
        return reported or any(map(self.namesakes, NODES))

    def _reported_namesakes(self, node: str) -> int:
        """How many nodes ``node`` says there are of its name, itself included; 0 while unknown."""
        said = self.diagnostic(node)
        return count_among(said.values, NAMESAKES) if said is not None else 0

    def namesakes(self, node: str) -> str | None:
        """Say that several nodes are called ``node`` here, as of two rigs; None where one is."""
        found = count_nodes(self.observer.node, node, self.namespace)
        count = max(found, self._reported_namesakes(node))
        domain = self.observer.context.get_domain_id()
        return namesakes_text(count, node, self.namespace, domain)

    def missing(self, node: str, timeout: float) -> str:
        """Say that ``node`` has not appeared, and what to do about it."""
        domain = self.observer.context.get_domain_id()
        if not self.is_known(PLANT) and self.is_unheard():
            return f"{self.name(JOINT_STATES)} of ROS domain {domain} does not arrive, {WAY_OUT}"
        elsewhere = sorted(
            {where for name, where in self._nodes() if name == node and where != self.namespace}
        )
        other = CONTROLLER if node == PLANT else PLANT
        if elsewhere and not self.is_known(other):
            advice = f"there is one in {', '.join(elsewhere)}: use --namespace"
        elif self.is_known(other):
            advice = f"the {other} is there, so {ABSENT}; or choose another --namespace"
        else:
            advice = (
                "start a rig with rodless rig, whose first start compiles for a minute or more, or "
                "choose its ROS_DOMAIN_ID and --namespace"
            )
        return (
            f"no {node} in namespace {self.namespace} of ROS domain {domain} within "
            f"{timeout:g} s; {advice}"
        )

    def unreported(self, node: str, timeout: float) -> str:
        """Say that ``node`` has not reported: it is silent, or not there at all."""
        if not self.is_known(node):
            return self.missing(node, timeout)
        return f"the {node} is there but has published nothing on /diagnostics within {timeout:g} s"

    def hides(self, node: str) -> bool:
        """Whether ``node`` is not known here, and the plant says that it commands the valve.

        Who joins a domain learns nothing of a node that is frozen; who has met it before knows it
        on, for 20 s. It is no use to ask before the plant has reported.
        """
        said = self.diagnostic(PLANT)
        commanders = said.values.get(COMMANDED_BY, "").split(", ") if said is not None else []
        return self.name(node) in commanders and not self.is_known(node)

    def hidden(self, node: str) -> str:
        """Say that ``node`` is there and does not show itself, and what to do about it."""
        return (
            f"the plant knows {self.name(node)}, which does not show itself here: it is frozen, "
            "was killed in the last 20 s, or its machine is too busy; let it go on, or end it and "
            "ask again after 20 s"
        )

    def _nodes(self) -> list[tuple[str, str]]:
        return list(self.observer.node.get_node_names_and_namespaces())

    def diagnostic(self, node: str) -> Diagnostic | None:
        """Return what a node last said of itself, None before it has."""
        return self._diagnostics.get(self.name(node))

    def next_diagnostic(self, node: str, timeout: float) -> Diagnostic | None:
        """Wait for the next report of a node; return None where none comes within ``timeout`` s."""
        self.observer.forget_diagnostic(node)
        self.wait_for(lambda: self.diagnostic(node), timeout)
        return self.diagnostic(node)

    def is_silent(self, node: str) -> bool:
        """Whether a node has not reported for a while, or not at all."""
        return is_silent(self.diagnostic(node))

    def state_of(self, node: str) -> str:
        """Return what a node says of its state, or that it says nothing any more."""
        said = self.diagnostic(node)
        return SILENT[node] if said is None or self.is_silent(node) else said.message

    def obstacles(self) -> list[str]:
        """Say what the nodes report that is not as it should be."""
        reports = {node: self.diagnostic(node) for node in NODES}
        return [
            f"{node}: {self.state_of(node)}"
            for node, said in reports.items()
            if said is None or self.is_silent(node) or said.level != DiagnosticStatus.OK
        ]

    def rivals(self) -> list[str]:
        """Say that several nodes command the valve, if they do."""
        topic = self.name(VALVE_VOLTAGE)

        def text() -> str | None:
            return rivals_text(publishers_of(self.observer.node, topic))

        # The name of a node that has just come is not known at once, and makes it two.
        self.wait_for(lambda: text() is None, NAME_TIMEOUT)
        return list(filter(None, [text()]))

    def parameter_types(self, node: str, names: Sequence[str]) -> dict[str, int]:
        """Return the declared types of parameters, as in ``rcl_interfaces/ParameterType``."""
        client = self.observer.parameter_client(node)
        answer = self.observer.result(
            lambda: client.describe_parameters(list(names)), f"the parameters of {node}"
        )
        return {found.name: found.type for found in answer.descriptors}
