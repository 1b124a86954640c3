# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Which parameters the controller node has: those of the law that it is given."""

from rclpy.node import Node

from rodless_base.ros.given import given_parameters
from rodless_control.controller_parameters import ControllerParameters
from rodless_control.parameters import NODE_PARAMETERS


def parameters_of_law(node: Node) -> tuple[type[ControllerParameters], dict[str, object]]:
    """Return the node's set for the law it is given, and all that it is given.

    What other laws are given is left out of the node.
    """
    declared = NODE_PARAMETERS["controller.law"]
    given = given_parameters(node, ControllerParameters.NODE)
    name = declared.check(given.get(declared.name, declared.default))
    kind = ControllerParameters.for_law(str(name))
    others = given.keys() - kind.own(given).keys()
    for other in filter(node.has_parameter, others):
        node.undeclare_parameter(other)
    if others:
        node.get_logger().info(
            f"controller.law {name}: leaving out parameters of other laws: "
            + ", ".join(sorted(others))
        )
    return kind, given
