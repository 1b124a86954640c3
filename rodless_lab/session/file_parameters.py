# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What a user's parameter file gives to the nodes of a rig."""

from pathlib import Path

from rodless_base.parameter_file import parameters_for, section_names
from rodless_base.parameters import errors_of_file
from rodless_control import ControllerParameters
from rodless_sim import RigParameters


def own_parameters(path: Path, namespace: str) -> dict[str, dict[str, object]]:
    """Return what a parameter file gives to each node of the rig in ``namespace``.

    ROS would read the file by rules of its own: a key that stands twice counts the last time, a
    section for all nodes goes before one for the plant. Here it means what it means to
    ``RigParameters.from_file``. Raises ParameterError for a file that is none, or is for others.
    """
    with errors_of_file(path):
        found = {
            kind.NODE: parameters_for(path, kind.NODE, kind.foreign, namespace)
            for kind in (RigParameters, ControllerParameters)
        }
        if not any(found.values()):
            raise ValueError(
                f"no section is for the plant or controller of namespace {namespace or '/'}; it "
                f"has {', '.join(section_names(path))}"
            )
    return found
