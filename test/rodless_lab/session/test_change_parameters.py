"""What is said of a change that the second node refuses or does not answer; nodes by stand-ins."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager

import pytest
from rcl_interfaces.msg import ParameterType

from rodless_lab.session.errors import HarnessError, RefusedError, WaitTimeoutError
from rodless_lab.session.running_rig import RigError
from rodless_lab.session.set_parameters import change_parameters

SHARES = {"plant:supply.pressure": "5e5", "controller:controller.kp": "7"}
TIMEOUT = 3.5


class StandInObserver:
    """Holds parameters by node; ``trouble`` is asked before each change what goes wrong."""

    def __init__(self, trouble: Callable[[str, int], HarnessError | None]) -> None:
        self.values: dict[str, dict[str, object]] = {
            "plant": {"supply.pressure": 6e5},
            "controller": {"controller.kp": 8.0},
        }
        self.timeouts: list[float] = []
        self._trouble = trouble

    def parameter_names(self, node: str) -> list[str]:
        """As the observer does."""
        return list(self.values[node])

    def get_parameters(self, node: str, names: Sequence[str]) -> dict[str, object]:
        """As the observer does."""
        return {name: self.values[node][name] for name in names}

    def set_parameters(self, node: str, values: Mapping[str, object], timeout: float) -> None:
        """Change them, or raise what goes wrong."""
        self.timeouts.append(timeout)
        error = self._trouble(node, len(self.timeouts))
        if error is not None:
            raise error
        self.values[node].update(values)


class StandInRig:
    """A rig of these nodes."""

    def __init__(self, observer: StandInObserver, nodes: Sequence[str]) -> None:
        self.observer, self._nodes = observer, nodes

    def is_known(self, node: str) -> bool:
        """As the rig does."""
        return node in self._nodes

    def wait_for(self, condition: Callable[[], object], timeout: float) -> bool:
        """Wait for nothing."""
        assert timeout > 0.0
        return bool(condition())

    def check_alone(self) -> None:
        """Nobody has the same name."""

    def parameter_types(self, _node: str, names: Sequence[str]) -> dict[str, int]:
        """As the rig does."""
        return dict.fromkeys(names, ParameterType.PARAMETER_DOUBLE)

    @contextmanager
    def uninterrupted(self) -> Iterator[None]:
        """Nobody interrupts."""
        yield


def failure(trouble: Callable[[str, int], HarnessError | None]) -> tuple[str, StandInObserver]:
    """Return the error of a change of both nodes, and what they hold then."""
    observer = StandInObserver(trouble)
    with pytest.raises(RigError) as raised:
        change_parameters(StandInRig(observer, ("plant", "controller")), SHARES, TIMEOUT)
    assert set(observer.timeouts) == {TIMEOUT}
    return str(raised.value), observer


def test_a_refusal_leaves_both_nodes_as_they_were() -> None:
    """The first gets its old value back; only then is it said that nothing has changed."""
    refused = RefusedError("controller.kp: too much")
    text, observer = failure(lambda node, _: refused if node == "controller" else None)
    assert text == "controller: controller.kp: too much; nothing has changed"
    assert observer.values["plant"] == {"supply.pressure": 6e5}


def test_a_node_that_does_not_answer_may_have_changed() -> None:
    """That is said, not that nothing has changed; the first gets its old value back."""
    late = WaitTimeoutError("timed out")
    text, observer = failure(lambda node, _: late if node == "controller" else None)
    assert text == (
        "controller has not answered: whether it has taken the values is unknown; check with "
        "rodless status"
    )
    assert observer.values["plant"] == {"supply.pressure": 6e5}


@pytest.mark.parametrize("second", [RefusedError("no"), WaitTimeoutError("timed out")])
def test_a_first_node_that_keeps_the_new_values_is_named(second: HarnessError) -> None:
    """Where the old values cannot be given back, it is not said that nothing has changed."""
    gone = WaitTimeoutError("timed out after 3.5 s")
    text, observer = failure(
        lambda node, k: second if node == "controller" else (k > 2 and gone) or None
    )
    assert text.endswith("; plant keeps the new values: timed out after 3.5 s")
    assert "nothing has changed" not in text
    assert observer.values["plant"] == {"supply.pressure": 5e5}


@pytest.mark.parametrize(("there", "absent"), [("plant", "controller"), ("controller", "plant")])
def test_a_node_that_is_not_there_is_named_beside_the_parameter(there: str, absent: str) -> None:
    """The parameter may be the missing node's, and is not called unknown without saying so."""
    rig = StandInRig(StandInObserver(lambda *_: None), (there,))
    with pytest.raises(RigError, match=f"on {there}; the {absent} was not found"):
        change_parameters(rig, {"reference.type": "sine"}, TIMEOUT)
