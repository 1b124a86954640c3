# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What is said of a change that the second node refuses or does not answer; nodes by stand-ins."""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager

import pytest
from rcl_interfaces.msg import ParameterType

from rodless_control import ControllerParameters
from rodless_lab.session.errors import HarnessError, RefusedError, WaitTimeoutError
from rodless_lab.session.running_rig import RigError
from rodless_lab.session.set_parameters import change_parameters
from rodless_sim import RigParameters

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
        self.alone = True

    def is_known(self, node: str) -> bool:
        """As the rig does."""
        return node in self._nodes

    def wait_for(self, condition: Callable[[], object], timeout: float) -> bool:
        """Wait for nothing."""
        assert timeout > 0.0
        return bool(condition())

    def check_alone(self) -> None:
        """As the rig does."""
        if not self.alone:
            raise RigError("2 nodes")

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
        "rodless get"
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


def test_any_other_trouble_leaves_no_half_of_a_change_behind() -> None:
    """Whatever comes up while the second node is asked, the first gets its old value back."""
    observer = StandInObserver(lambda node, _: trouble if node == "controller" else None)
    trouble = HarnessError("the context is gone")
    with pytest.raises(HarnessError, match="the context is gone"):
        change_parameters(StandInRig(observer, ("plant", "controller")), SHARES, TIMEOUT)
    assert observer.values["plant"] == {"supply.pressure": 6e5}


def test_one_parameter_under_two_names_is_given_twice() -> None:
    """With the node before it and without; nothing is sent."""
    observer = StandInObserver(lambda *_: None)
    given = {"plant:supply.pressure": "5e5", "supply.pressure": "4e5"}
    with pytest.raises(RigError, match=r"supply\.pressure: given twice for the plant"):
        change_parameters(StandInRig(observer, ("plant", "controller")), given, TIMEOUT)
    assert not observer.timeouts
    assert observer.values["plant"] == {"supply.pressure": 6e5}


def rig_of_this_package(observer: StandInObserver) -> StandInRig:
    """A rig whose nodes have all parameters of this package's."""
    observer.values = {"plant": dict(RigParameters()), "controller": dict(ControllerParameters())}
    return StandInRig(observer, ("plant", "controller"))


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"controller.kp": "7", "supply.pressure": "90000"}, "below atmosphere.pressure"),
        ({"supply.pressure": "5e5", "controller.kp": "-1"}, "controller.kp: -1.0 refused"),
        ({"supply.pressure": "5e5", "reference.minimum": "0.3"}, "must be less than"),
        ({"supply.pressure": "5e5", "time.period": "0.1"}, "cannot change while the node runs"),
    ],
)
def test_what_can_be_checked_is_checked_before_anything_is_sent(
    given: dict[str, str], words: str
) -> None:
    """A change that either node would refuse reaches neither: a running sine is not disturbed."""
    observer = StandInObserver(lambda *_: None)
    rig = rig_of_this_package(observer)
    before = {node: dict(values) for node, values in observer.values.items()}
    with pytest.raises(RigError, match=re.escape(words)):
        change_parameters(rig, given, TIMEOUT)
    assert not observer.timeouts
    assert observer.values == before


def test_what_fits_reaches_the_plant_first() -> None:
    """It alone refuses for reasons of its state, and then the controller has not been disturbed."""
    asked: list[str] = []
    observer = StandInObserver(lambda node, _: asked.append(node))
    given = {"controller.kp": "7", "supply.pressure": "5e5"}
    changes = change_parameters(rig_of_this_package(observer), given, TIMEOUT)
    assert asked == ["plant", "controller"]
    assert [(change.name, change.new) for change in changes] == [
        ("supply.pressure", 5e5),
        ("controller.kp", 7.0),
    ]


def test_a_rig_with_a_namesake_is_not_changed() -> None:
    """One of two would take the change, or both."""
    observer = StandInObserver(lambda *_: None)
    rig = StandInRig(observer, ("plant", "controller"))
    rig.alone = False
    with pytest.raises(RigError, match="2 nodes"):
        change_parameters(rig, SHARES, TIMEOUT)
    assert not observer.timeouts
