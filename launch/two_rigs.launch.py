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
"""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, GroupAction, IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import EqualsSubstitution, LaunchConfiguration

RIG = Path(get_package_share_directory("rodless_sim"), "launch", "rig.launch.py")
NAMES = ["left", "right"]


def rig(name: str) -> GroupAction:
    """Return the rig in the namespace ``name``; what it is given stays with it."""
    arguments = {
        "namespace": name,
        "preset": LaunchConfiguration(f"{name}_preset"),
        "publish_clock": EqualsSubstitution(LaunchConfiguration("clock"), name),
    }
    source = PythonLaunchDescriptionSource(str(RIG))
    return GroupAction([IncludeLaunchDescription(source, launch_arguments=arguments.items())])


def generate_launch_description() -> LaunchDescription:
    """Describe both rigs."""
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "clock",
                default_value="none",
                choices=["none", *NAMES],
                description="whose time /clock shows to nodes of neither rig",
            ),
            *(
                DeclareLaunchArgument(
                    f"{name}_preset", default_value="paper", description=f"preset of {name}"
                )
                for name in NAMES
            ),
            *map(rig, NAMES),
        ]
    )
