# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Whether a node would take a change, found out here: by the declarations and checks it has too."""

from collections.abc import Mapping

from rodless_base.parameter_file import is_of_rclpy
from rodless_base.parameters import ParameterError, ParameterSet
from rodless_control import ControllerParameters
from rodless_control.laws import LAWS, law_class
from rodless_lab.session.running_rig import CONTROLLER, PLANT, RigError
from rodless_sim import RigParameters


def check_change(node: str, present: Mapping[str, object], changes: Mapping[str, object]) -> None:
    """Raise :class:`RigError` where ``node``, whose values are ``present``, refuses ``changes``.

    Nothing is sent. A node that is not of this package judges for itself, and so does each on what
    depends on its state; with another law each value is checked alone.
    """
    kind = _set_of(node, {**present, **changes})
    law = str(changes.get("controller.law"))
    another = law in LAWS and law != present.get("controller.law")
    if another:
        # Compiled here, and kept on the disk, it keeps the controller waiting for a moment only.
        law_class(law)()
    if kind is None:
        return
    ours = {name: value for name, value in changes.items() if not is_of_rclpy(name)}
    try:
        if kind.DECLARATIONS.keys() <= present.keys():
            _check_as_a_whole(kind, node, present, ours)
        elif another:
            for name in kind.DECLARATIONS.keys() & ours.keys():
                kind.DECLARATIONS[name].check(ours[name])
    except ParameterError as error:
        raise RigError(f"{node}: {error}; nothing has changed") from error


def _check_as_a_whole(
    kind: type[ParameterSet], node: str, present: Mapping[str, object], ours: Mapping[str, object]
) -> None:
    for name in ours:
        if name in kind.DECLARATIONS and kind.DECLARATIONS[name].fixed:
            raise RigError(f"{node}: {name}: cannot change while the node runs; start it anew")
    kind({name: present[name] for name in kind.DECLARATIONS} | dict(ours))


def _set_of(node: str, values: Mapping[str, object]) -> type[ParameterSet] | None:
    """Return the class of the node's parameters, None where it is not known here."""
    if node == PLANT:
        return RigParameters
    assert node == CONTROLLER
    return controller_set(values.get("controller.law"))


def controller_set(law: object) -> type[ControllerParameters] | None:
    """Return the class of a controller's parameters by its law, None where it is not known here."""
    try:
        return ControllerParameters.for_law(str(law))
    except ParameterError:
        # A law that only the node's own environment has.
        return None
