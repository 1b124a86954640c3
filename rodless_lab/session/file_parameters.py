# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What a user's parameter file gives to the nodes of a rig."""

import warnings
from collections.abc import Mapping
from pathlib import Path

from rodless_base.parameter_file import (
    check_for_one_rig,
    is_of_rclpy,
    parameters_for,
    read_parameter_file,
)
from rodless_base.parameters import ParameterSet, errors_of_file
from rodless_control import ControllerParameters
from rodless_control.controller_parameters import DEFAULT_LAW
from rodless_control.laws import LAWS
from rodless_sim import RigParameters


def own_parameters(path: Path, namespace: str) -> dict[str, dict[str, object]]:
    """Return what a parameter file gives to each node of the rig in ``namespace``.

    ROS would read the file by rules of its own: a key that stands twice counts the last time, a
    section for all nodes goes before one for the plant. Here it means what it means to
    ``RigParameters.from_file``. Raises ParameterError for a file that is none, or is for others.
    """
    with errors_of_file(path):
        check_for_one_rig(path, namespace)
        return {
            kind.NODE: parameters_for(path, kind.NODE, kind.foreign, namespace)
            for kind in (RigParameters, ControllerParameters)
        }


def reference_maximum(stroke: float, of_file: Mapping[str, Mapping[str, object]]) -> object:
    """Return ``reference.maximum`` for a cylinder's stroke (m): a file's own where that is less.

    One that is no number is left to its node to refuse.
    """
    own = of_file["controller"].get("reference.maximum", stroke)
    return stroke if isinstance(own, int | float) and own > stroke else own


def check_together(
    path: Path,
    preset: Path,
    of_file: Mapping[str, Mapping[str, object]],
    on_top: Mapping[str, Mapping[str, object]],
) -> None:
    """Raise ParameterError where a node would refuse the preset with the values on it, by node.

    ``path`` is the file that gives ``of_file``; the nodes are those of ``on_top``. A law of the
    user's own is left to its node, which may find it where this process does not.
    """
    with errors_of_file(path), warnings.catch_warnings():
        warnings.simplefilter("ignore", FutureWarning)  # the node says them
        for kind in (RigParameters, ControllerParameters):
            if kind.NODE not in on_top:
                continue
            given = read_parameter_file(preset, kind.NODE, kind.foreign)
            given |= {**of_file[kind.NODE], **on_top[kind.NODE]}
            _check({name: value for name, value in given.items() if not is_of_rclpy(name)}, kind)


def _check(values: Mapping[str, object], kind: type[ParameterSet]) -> None:
    if kind is ControllerParameters:
        law = values.get("controller.law", DEFAULT_LAW)
        if law not in LAWS and ":" in str(law):
            return
        kind = ControllerParameters.for_law(str(law))
    kind(kind.own(values))
