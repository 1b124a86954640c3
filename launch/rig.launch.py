"""Start the plant and the controller: `ros2 launch rodless_sim rig.launch.py preset:=paper`."""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

PRESETS = sorted(
    file.stem for file in Path(get_package_share_directory("rodless_sim"), "config").glob("*.yaml")
)


def start_rig(context: LaunchContext) -> list[Node]:
    """Return both nodes; the launch ends when either does, so that a dead node is seen."""
    chosen = {
        name: LaunchConfiguration(name).perform(context)
        for name in ("preset", "supply_pressure", "namespace")
    }
    share = Path(get_package_share_directory("rodless_sim"))
    preset = str(share / "config" / f"{chosen['preset']}.yaml")
    plant: list[object] = [preset]
    if chosen["supply_pressure"]:
        plant.append({"supply.pressure": float(chosen["supply_pressure"])})
    common = {
        "package": "rodless_sim",
        "namespace": chosen["namespace"],
        "output": "screen",
        "on_exit": Shutdown(),
    }
    return [
        Node(executable="plant", name="plant", parameters=plant, **common),
        Node(
            executable="controller",
            name="controller",
            parameters=[preset, {"use_sim_time": True}],
            **common,
        ),
    ]


def generate_launch_description() -> LaunchDescription:
    """Describe the arguments and the rig."""
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "preset", default_value="paper", choices=PRESETS, description="parameter preset"
            ),
            DeclareLaunchArgument(
                "supply_pressure",
                default_value="",
                description="supply pressure in Pa, absolute; empty: the preset's",
            ),
            DeclareLaunchArgument(
                "namespace", default_value="", description="namespace of both nodes"
            ),
            OpaqueFunction(function=start_rig),
        ]
    )
