# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Two rigs side by side: `ros2 launch rodless_sim two_rigs.launch.py`.

They move by themselves (`rodless move 58 --namespace left`) and hear nothing of each other. Each
publishes its time on its own `clock`; at most one of them on `/clock`, for nodes of neither rig.
Arguments of `rig.launch.py`, such as `speed:=0.5`, hold for both; `left_preset:=`,
`left_parameters:=` and `left_bag:=` for one.
"""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchContext, LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    GroupAction,
    IncludeLaunchDescription,
    OpaqueFunction,
)
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.logging import get_logger
from launch.substitutions import EqualsSubstitution, LaunchConfiguration

from rodless_lab.session.launch_arguments import misspelt

RIG = Path(get_package_share_directory("rodless_sim"), "launch", "rig.launch.py")
NAMES = ["left", "right"]


# Name, default, choices, meaning.
ARGUMENTS = (
    ("clock", "none", ["none", *NAMES], "whose time /clock shows to nodes of neither rig"),
    *(
        (
            f"{name}_{argument}",
            LaunchConfiguration(argument, default=default),
            None,
            f"{meaning} of {name}; not given: that of both, {argument}:={default}",
        )
        for argument, default, meaning in (
            ("preset", "paper", "preset"),
            ("parameters", "", "parameter file"),
        )
        for name in NAMES
    ),
    *(
        (f"{name}_bag", "", None, f"folder of the bag of {name}; given: it records")
        for name in NAMES
    ),
)


def rig(name: str) -> GroupAction:
    """Return the rig in the namespace ``name``; what it is given stays with it."""
    arguments = {
        "namespace": name,
        "preset": LaunchConfiguration(f"{name}_preset"),
        "parameters": LaunchConfiguration(f"{name}_parameters"),
        "bag": LaunchConfiguration(f"{name}_bag"),
        "publish_clock": EqualsSubstitution(LaunchConfiguration("clock"), name),
    }
    source = PythonLaunchDescriptionSource(str(RIG))
    return GroupAction([IncludeLaunchDescription(source, launch_arguments=arguments.items())])


def check_arguments(context: LaunchContext) -> None:
    """Log a warning of each argument that has no effect, or is likely a misspelt one of this file.

    Raises RuntimeError where both rigs would record into one bag.
    """
    given = context.launch_configurations
    named = any(given[f"{name}_bag"] for name in NAMES)
    if given.get("bag") or (given.get("record") == "true" and not named):
        raise RuntimeError(
            "bag:= and record:=true refused: each rig has a bag of its own; give left_bag:= or "
            "right_bag:=, or both"
        )
    left, right = (given[f"{name}_bag"] for name in NAMES)
    if left and right and Path(left).resolve() == Path(right).resolve():
        raise RuntimeError(
            f"left_bag:={left} and right_bag:={right} refused: they are one bag; give two"
        )
    if given.get("namespace"):
        warn(f"namespace:={given['namespace']} changes nothing: the rigs are in left and right")
    if given.get("publish_clock", "auto") != "auto":
        warn("publish_clock:= changes nothing: clock:= says whose time /clock shows")
    for line in misspelt(given, [name for name, *_ in ARGUMENTS], Path(__file__).name):
        warn(line)


def warn(line: str) -> None:
    """Log a warning."""
    get_logger("rodless_sim").warning(line)


def generate_launch_description() -> LaunchDescription:
    """Describe both rigs."""
    arguments = [
        DeclareLaunchArgument(name, default_value=default, choices=choices, description=text)
        for name, default, choices, text in ARGUMENTS
    ]
    return LaunchDescription(
        [*arguments, OpaqueFunction(function=check_arguments), *map(rig, NAMES)]
    )
