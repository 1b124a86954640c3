# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Names of frames and joints with a prefix, so that several rigs fit into one robot model."""

from collections.abc import Sequence

from rodless_base.parameters import Parameter, ParameterError, ParameterSet, declare

PARAMETERS = declare(
    Parameter(
        "frame_prefix",
        "",
        "",
        "put before every frame_id and joint name, as robot_state_publisher does: left/",
        "interface",
        fixed=True,
        in_runs=False,
    )
)


def check(parameters: ParameterSet) -> None:
    """Refuse what tf2 refuses: a name of a frame that begins with a slash."""
    prefix = parameters.text("frame_prefix")
    if prefix.startswith("/"):
        raise ParameterError(
            f"frame_prefix: {prefix!r} refused, frames have no leading slash; "
            f"write {prefix.lstrip('/')!r}"
        )


def prefixed(parameters: ParameterSet, name: str) -> str:
    """Return a frame's or joint's ``name`` with the prefix of ``parameters``."""
    return parameters.text("frame_prefix") + name


def joint_among(joint: str, names: Sequence[str]) -> str | None:
    """Return the name that ``joint`` has among ``names``, whatever its prefix.

    None where it is not there, or more than once with a prefix.

    Examples
    --------
    >>> joint_among("carriage", ["left/carriage", "gripper"])
    'left/carriage'
    """
    if joint in names:
        return joint
    found = [name for name in names if name.endswith(joint)]
    return found[0] if len(found) == 1 else None
