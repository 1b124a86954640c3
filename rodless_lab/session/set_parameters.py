# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Read parameters of a running rig, and change them: on whichever node has each, all or none."""

import difflib
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import yaml
from diagnostic_msgs.msg import DiagnosticStatus
from rcl_interfaces.msg import ParameterType
from rclpy.parameter import Parameter as RosParameter

from rodless_base.one_line import shown
from rodless_base.parameter_file import is_of_rclpy
from rodless_base.parameters import LARGEST_INTEGER, SMALLEST_INTEGER, Parameter
from rodless_base.ros.parameters import ros_value
from rodless_base.written_number import written_number
from rodless_base.yaml_file import yaml_value
from rodless_control.laws import LAWS, of_other_law
from rodless_control.parameters import LAW
from rodless_lab.session.dry_run import check_change, controller_set
from rodless_lab.session.errors import (
    HarnessError,
    NotYetError,
    RefusedError,
    WaitTimeoutError,
)
from rodless_lab.session.running_rig import (
    ABSENT,
    CONTROLLER,
    NODES,
    OTHER_NODE_TIMEOUT,
    PLANT,
    RigError,
    RunningRig,
)

# What the controller counts in its diagnostics, which come once a second.
LAW_FAILURES = "failures of the law"
REPORT_TIMEOUT = 5.0

SILENT = "does not answer any more; its law may not return"

# For a controller to load another law, in wall-clock s.
LAW_TIMEOUT = 30.0

# For another process to compile what the plant needs, in wall-clock s: slow beside much else.
COMPILING_TIMEOUT = 1800.0


@dataclass(frozen=True)
class Change:
    """One parameter that has changed."""

    node: str
    name: str
    old: object  # None where the law before had no such parameter
    new: object


class RigNotYetError(RigError, NotYetError):
    """A change that the plant takes only in a while; nothing has changed."""


def change_parameters(rig: RunningRig, given: Mapping[str, str], timeout: float) -> list[Change]:
    """Set parameters to the values that the texts ``given`` stand for; return what has changed.

    A name may have the node before it, ``plant:NAME``; with another law come that law's own
    parameters. Everything is checked before anything is
    sent; then each node takes its share as one change. If the second node refuses its own for a
    reason that only it knows, the first gets its old values back after running with the new ones
    for a few milliseconds. The nodes have ``timeout`` (wall-clock s) to be found, and again for
    each answer. Raises :class:`RigNotYetError` where the plant has to compile first, and
    :class:`RigError` for a rig that is not there, a name that no node or more
    than one has, a parameter given twice, a value that cannot be, with the node's own reason where
    it refuses, and where a node does not answer; the text then says what has changed.
    """
    present = {node: rig.observer.parameter_names(node) for node in _found(rig, timeout)}
    coming = _of_coming_law(given) if CONTROLLER in present else {}
    names = {**present, CONTROLLER: _with_law(present[CONTROLLER], coming)} if coming else present
    shares: dict[str, dict[str, str]] = {}
    for name, text in given.items():
        node, bare = _owner(name, names)
        if bare in shares.setdefault(node, {}):
            raise RigError(f"{bare}: given twice for the {node}")
        shares[node][bare] = text
    # The plant first: only it refuses for reasons that cannot be checked before.
    values = {node: _typed(rig, node, shares[node], coming) for node in NODES if node in shares}
    old = {node: rig.observer.get_parameters(node, present[node]) for node in values}
    for node, share in values.items():
        check_change(node, old[node], share)
    rig.check_alone()
    if LAW in shares.get(CONTROLLER, {}):
        timeout = max(timeout, LAW_TIMEOUT)
    with rig.uninterrupted():
        _set_all(rig, values, old, timeout)
    return [
        Change(node, name, old[node].get(name), share[name])
        for node, share in values.items()
        for name in share
    ]


def change_once_ready(
    rig: RunningRig, given: Mapping[str, str], timeout: float, tell: Callable[[], object]
) -> list[Change]:
    """:func:`change_parameters`, after ``tell`` and a wait where the plant has to compile first."""
    return rig.observer.once_ready(
        lambda: change_parameters(rig, given, timeout), COMPILING_TIMEOUT, tell
    )


def parameter_values(rig: RunningRig, wanted: Sequence[str], timeout: float) -> dict[str, object]:
    """Return parameters by name, all of both nodes if none is ``wanted``.

    A name that both nodes have comes with the node before it. Raises as :func:`change_parameters`.
    """
    names = {node: rig.observer.parameter_names(node) for node in _found(rig, timeout)}
    has = {node: rig.observer.get_parameters(node, names[node]) for node in names}
    if wanted:
        owners = {name: _owner(name, names) for name in wanted}
        return {name: has[node][bare] for name, (node, bare) in owners.items()}
    count = Counter(name for node in names for name in names[node])
    return {
        name if count[name] == 1 else f"{node}:{name}": value
        for node, values in has.items()
        for name, value in values.items()
    }


def failed_law(rig: RunningRig) -> str | None:
    """Return what the controller says where its law has failed, as by a change of parameters.

    Laws of this package do not fail by one; for another law this waits for the next report. A
    controller that says nothing any more does not come back from its law.
    """
    try:
        law = rig.observer.get_parameters(CONTROLLER, ["controller.law"])["controller.law"]
    except RefusedError:  # of another controller
        return None
    except WaitTimeoutError:
        return SILENT
    if law in LAWS:
        return None
    said = rig.next_diagnostic(CONTROLLER, REPORT_TIMEOUT)
    if said is None:
        return SILENT
    failed = said.level == DiagnosticStatus.ERROR
    return said.message if failed and said.values.get(LAW_FAILURES, "0") != "0" else None


def _found(rig: RunningRig, timeout: float) -> list[str]:
    """Wait for both nodes, for the second only a moment; of a name there must be one alone."""
    if not rig.wait_for(lambda: any(map(rig.is_known, NODES)), timeout):
        raise RigError(rig.missing(PLANT, timeout))
    rig.wait_for(lambda: all(map(rig.is_known, NODES)), min(timeout, OTHER_NODE_TIMEOUT))
    # First of all: with twins it is open who answers, and which.
    rig.check_alone()
    return [node for node in NODES if rig.is_known(node)]


def _of_coming_law(given: Mapping[str, str]) -> Mapping[str, Parameter]:
    """Return what the controller declares with the law that is ``given``; nothing for no law."""
    law = given.get(LAW, given.get(f"{CONTROLLER}:{LAW}"))
    kind = None if law is None else controller_set(law)
    return {} if kind is None else kind.DECLARATIONS


def _with_law(present: Iterable[str], coming: Iterable[str]) -> list[str]:
    """Return the names that a controller of ``present`` names has once a law has come."""
    return [*filter(is_of_rclpy, present), *coming]


def _owner(name: str, names: Mapping[str, list[str]]) -> tuple[str, str]:
    """Return the one node that has a parameter, and its name there."""
    wanted, _, bare = name.rpartition(":")
    if wanted and wanted not in names:
        raise RigError(f"{name}: no node {wanted} here; there is {' and '.join(names)}")
    asked = {wanted: names[wanted]} if wanted else names
    owners = [node for node, has in asked.items() if bare in has]
    if len(owners) > 1:
        ways = " or ".join(f"{node}:{bare}" for node in owners)
        raise RigError(f"{bare}: {' and '.join(owners)} have it; say {ways}")
    if not owners:
        there = [name for has in asked.values() for name in has]
        if CONTROLLER in asked and (other := of_other_law(bare, there)):
            raise RigError(f"{bare}: {other}; set that first")
        near = difflib.get_close_matches(bare, there, n=1)
        hint = f"; did you mean {near[0]}?" if near else ""
        absent = "".join(
            f"; the {node} was not found: {ABSENT}" for node in NODES if node not in names
        )
        raise RigError(f"{bare}: no such parameter on {' or '.join(asked)}{hint}{absent}")
    return owners[0], bare


def _typed(
    rig: RunningRig, node: str, texts: Mapping[str, str], coming: Mapping[str, Parameter]
) -> dict[str, object]:
    """Return what ``texts`` stand for; what only a ``coming`` law has is of its default's type."""
    types = rig.parameter_types(node, [name for name in texts if name not in coming])
    own = coming if node == CONTROLLER else {}
    types |= {name: _type_of(one) for name, one in own.items()}
    return {name: typed_value(name, text, types[name]) for name, text in texts.items()}


def _type_of(declared: Parameter) -> int:
    default = ros_value(declared.default)
    return int(RosParameter.Type.from_parameter_value(default).value)


def typed_value(name: str, text: str, kind: int) -> object:
    """Return what ``text`` stands for in a parameter of ``kind``; raises :class:`RigError`."""
    if kind == ParameterType.PARAMETER_STRING:
        return text
    convert, wanted = _KINDS.get(kind, (yaml_value, "a value"))
    try:
        return convert(text)
    except (ValueError, yaml.YAMLError) as error:
        raise RigError(f"{name}: {shown(text)} refused, must be {wanted}") from error


def _boolean(text: str) -> bool:
    if text.lower() not in ("true", "false"):
        raise ValueError(text)
    return text.lower() == "true"


def _integer(text: str) -> int:
    real = written_number(text)
    try:
        number = int(text)
    except ValueError:
        if not real.is_integer():
            raise
        number = int(real)  # such as 1e3
    if not SMALLEST_INTEGER <= number <= LARGEST_INTEGER:
        raise ValueError(text)
    return number


def _numbers(text: str) -> list[float]:
    return [written_number(part) for part in text.strip("[] ").split(",")]


_KINDS: dict[int, tuple[Callable[[str], object], str]] = {
    ParameterType.PARAMETER_BOOL: (_boolean, "true or false"),
    ParameterType.PARAMETER_INTEGER: (_integer, "a whole number of at most 64 bits"),
    ParameterType.PARAMETER_DOUBLE: (written_number, "a number"),
    ParameterType.PARAMETER_DOUBLE_ARRAY: (_numbers, "numbers with commas between them"),
}


Values = Mapping[str, Mapping[str, object]]


def _set_all(rig: RunningRig, values: Values, old: Values, timeout: float) -> None:
    changed: list[str] = []
    for node, share in values.items():
        try:
            rig.observer.set_parameters(node, share, timeout)
        except RefusedError as error:
            kept = _take_back(rig, values, changed, old, timeout)
            kind = RigNotYetError if isinstance(error, NotYetError) else RigError
            raise kind(f"{node}: {error}; {kept or 'nothing has changed'}") from error
        except WaitTimeoutError as error:
            kept = _take_back(rig, values, changed, old, timeout)
            raise RigError(
                f"{node} has not answered: whether it has taken the values is unknown; check with "
                f"rodless get{kept and '; '}{kept}"
            ) from error
        except Exception:
            # Whatever it was, it must not leave half of a change behind.
            _take_back(rig, values, changed, old, timeout)
            raise
        changed.append(node)


def _take_back(
    rig: RunningRig, values: Values, nodes: Iterable[str], old: Values, timeout: float
) -> str:
    """Give nodes their old values; return what is to be said of those that keep the new ones."""
    kept = []
    for node in nodes:
        try:
            before = {name: old[node][name] for name in values[node]}
            rig.observer.set_parameters(node, before, timeout)
        except HarnessError as error:
            kept.append(f"{node} keeps the new values: {error}")
    return "; ".join(kept)
