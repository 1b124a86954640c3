"""A rig that runs already: its nodes found, in the domain and namespace that the user names."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from types import TracebackType

from rodless_base.start import Stop
from rodless_lab.session.domain import full_namespace
from rodless_lab.session.errors import HarnessError, InterruptedRunError, WaitTimeoutError
from rodless_lab.session.observer import Diagnostic, Observer

PLANT, CONTROLLER = "plant", "controller"


class RigError(HarnessError):
    """What was asked of a running rig cannot be done; the text says why, in one line."""


class RunningRig:
    """Plant and controller of one namespace, which somebody else has started.

    Waiting raises :class:`InterruptedRunError` as soon as ``stop`` is requested.
    """

    def __init__(self, namespace: str, stop: Stop) -> None:
        """Join the domain that the environment names; raises HarnessError for one it cannot."""
        self.namespace = full_namespace(namespace)
        self._stop = stop
        self._may_stop = True
        self.observer = Observer(namespace=self.namespace, check=self._check)
        # Asked for now, so that what the nodes say once a second is not missed.
        self._diagnostics = self.observer.diagnostics

    def __enter__(self) -> "RunningRig":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
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

    def wait_for_node(self, node: str, timeout: float) -> None:
        """Wait for ``node`` to appear; raises :class:`RigError` saying where there is one."""
        if not self.wait_for(lambda: self.is_known(node), timeout):
            raise RigError(self.missing(node, timeout))

    def missing(self, node: str, timeout: float) -> str:
        """Say that ``node`` has not appeared, and what to do about it."""
        elsewhere = sorted(
            {where for name, where in self._nodes() if name == node and where != self.namespace}
        )
        advice = (
            f"there is one in {', '.join(elsewhere)}: use --namespace"
            if elsewhere
            else "start a rig with rodless rig, or choose its ROS_DOMAIN_ID and --namespace"
        )
        domain = self.observer.context.get_domain_id()
        return (
            f"no {node} in namespace {self.namespace} of ROS domain {domain} within "
            f"{timeout:g} s; {advice}"
        )

    def unreported(self, node: str, timeout: float) -> str:
        """Say that ``node`` has not reported: it is silent, or not there at all."""
        if not self.is_known(node):
            return self.missing(node, timeout)
        return f"the {node} is there but has published nothing on /diagnostics within {timeout:g} s"

    def _nodes(self) -> list[tuple[str, str]]:
        return list(self.observer.node.get_node_names_and_namespaces())

    def diagnostic(self, node: str) -> Diagnostic | None:
        """Return what a node last said of itself, None before it has."""
        return self._diagnostics.get(self.name(node))

    def parameter_types(self, node: str, names: Sequence[str]) -> dict[str, int]:
        """Return the declared types of parameters, as in ``rcl_interfaces/ParameterType``."""
        client = self.observer.parameter_client(node)
        answer = self.observer.result(
            lambda: client.describe_parameters(list(names)), f"the parameters of {node}"
        )
        return {found.name: found.type for found in answer.descriptors}
