# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Which parameters the controller node has: those of the law that it is given."""

from collections.abc import Iterable, Iterator, Mapping
from itertools import groupby

from rclpy.node import Node

from rodless_base.parameters import ParameterError
from rodless_base.ros.given import given_parameters
from rodless_control.controller_parameters import ControllerParameters
from rodless_control.laws import LAWS
from rodless_control.parameters import LAW, NODE_PARAMETERS

# So many parameters of one prefix are named one by one.
FEW = 3


def parameters_of_law(node: Node) -> tuple[type[ControllerParameters], dict[str, object]]:
    """Return the node's set for the law it is given, and all that it is given.

    What other laws are given is left out of the node.
    """
    declared = NODE_PARAMETERS[LAW]
    given = given_parameters(node, ControllerParameters.NODE)
    name = declared.check(given.get(declared.name, declared.default))
    kind = ControllerParameters.for_law(str(name))
    others = given.keys() - kind.own(given).keys()
    for other in filter(node.has_parameter, others):
        node.undeclare_parameter(other)
    if others:
        node.get_logger().info(
            f"{LAW} {name}: leaving out parameters of other laws: " + ", ".join(_in_groups(others))
        )
    return kind, given


def _in_groups(names: Iterable[str]) -> Iterator[str]:
    """Yield names in order; of many with one prefix, as a preset gives them, the prefix alone."""
    for prefix, group in groupby(sorted(names), lambda name: name.partition(".")[0]):
        members = list(group)
        if len(members) > FEW:
            yield f"{prefix}.* ({len(members)})"
        else:
            yield from members


class LawChoice:
    """Which laws a running node can have, each with the values it had last, or was given."""

    def __init__(self, given: Mapping[str, object], law: object) -> None:
        """Take all that the node was ``given`` at its start, to other laws too, and its ``law``."""
        self._known = dict(given)
        # No message is to make a node import a module.
        self._laws = [*LAWS, *({str(law)} - LAWS.keys())]

    def next(
        self, values: ControllerParameters, changes: Mapping[str, object]
    ) -> ControllerParameters | None:
        """Return the node's set with another law, None where ``changes`` do not ask for one.

        What both laws have stays as it is in ``values``. Raises ParameterError for a law that is
        not to be had, and for values that it cannot have.
        """
        law = changes.get(LAW, values[LAW])
        if law == values[LAW]:
            return None
        if law not in self._laws:
            raise ParameterError(
                f"{LAW}: {law!r} refused, must be {', '.join(self._laws)} while the node runs; "
                "start it with another law"
            )
        kind = ControllerParameters.for_law(str(law))
        self._known.update(values)
        known = {name: self._known[name] for name in kind.DECLARATIONS.keys() & self._known.keys()}
        return kind({**known, **changes})
