"""Start the plant and the controller: `ros2 launch rodless_sim rig.launch.py preset:=paper`."""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

CONFIG = Path(get_package_share_directory("rodless_sim"), "config")
PRESETS = sorted(file.stem for file in CONFIG.glob("*.yaml"))

TOPICS = [
    "joint_states",
    "chamber_a/pressure",
    "chamber_b/pressure",
    "supply/pressure",
    "valve/voltage",
    "setpoint",
    "/clock",
]


def start_rig(context: LaunchContext) -> list[Node]:
    """Return the nodes; the launch ends when any does, so that a dead node is seen."""
    chosen = {
        name: LaunchConfiguration(name).perform(context)
        for name in ("preset", "sensors", "supply_pressure", "namespace", "mode", "bag")
    }
    recorded = LaunchConfiguration("record").perform(context) == "true"
    files = [str(CONFIG / f"{chosen['preset']}.yaml")]
    if chosen["sensors"] != "ideal":
        files.append(str(CONFIG / "sensors" / f"{chosen['sensors']}.yaml"))
    plant = {"time.mode": chosen["mode"], "time.recorders": int(recorded)}
    if chosen["supply_pressure"]:
        plant["supply.pressure"] = float(chosen["supply_pressure"])
    controller = {"use_sim_time": True, "controller.recorders": int(recorded)}
    common = {
        "package": "rodless_sim",
        "namespace": chosen["namespace"],
        "output": "screen",
        "on_exit": Shutdown(),
    }
    nodes = [
        Node(executable="plant", name="plant", parameters=[*files, plant], **common),
        Node(executable="controller", name="controller", parameters=[*files, controller], **common),
    ]
    if recorded:
        # `ros2 bag record --use-sim-time` subscribes only after the first /clock message, so its
        # bags lack the first samples; this recorder writes the same format and has them.
        output = ["--output", chosen["bag"]] if chosen["bag"] else []
        nodes.append(Node(executable="recorder", arguments=[*TOPICS, *output], **common))
    return nodes


def generate_launch_description() -> LaunchDescription:
    """Describe the arguments and the rig."""
    arguments = (
        ("preset", "paper", PRESETS, "parameter preset"),
        ("sensors", "ideal", ["ideal", "data_sheet"], "instruments: ideal, or the paper's"),
        ("supply_pressure", "", None, "supply pressure in Pa, absolute; empty: the preset's"),
        ("namespace", "", None, "namespace of all nodes"),
        ("mode", "realtime", ["realtime", "lockstep"], "what drives plant time"),
        ("record", "false", ["true", "false"], "record a bag from the first sample on"),
        ("bag", "", None, "folder of that bag; empty: named after the time"),
    )
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(
                    name, default_value=default, choices=choices, description=text
                )
                for name, default, choices, text in arguments
            ),
            OpaqueFunction(function=start_rig),
        ]
    )
