"""Start the plant and the controller: `ros2 launch rodless_sim rig.launch.py preset:=paper`."""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from rodless_base.topics import RIG_TOPICS

CONFIG = Path(get_package_share_directory("rodless_sim"), "config")
PRESETS = sorted(file.stem for file in CONFIG.glob("*.yaml"))
BOOL = ["true", "false"]

# Name, default, choices, meaning.
ARGUMENTS = (
    ("preset", "paper", PRESETS, "parameter preset"),
    ("sensors", "ideal", ["ideal", "data_sheet"], "instruments: ideal, or the paper's"),
    ("parameters", "", None, "parameter file on top of those"),
    ("supply_pressure", "", None, "supply pressure in Pa, absolute; empty: the preset's"),
    ("controller", "true", BOOL, "start our controller; false: the plant waits for yours"),
    ("namespace", "", None, "namespace of all nodes"),
    ("frame_prefix", "", None, "put before frame_ids and the joint's name: left/"),
    ("mode", "realtime", ["realtime", "lockstep"], "what drives plant time"),
    ("record", "false", BOOL, "record a bag from the first sample on"),
    ("bag", "", None, "folder of that bag; empty: named after the time"),
)


def start_rig(context: LaunchContext) -> list[Node]:
    """Return the nodes; the launch ends when any does, so that a dead node is seen."""
    chosen = {name: LaunchConfiguration(name).perform(context) for name, *_ in ARGUMENTS}
    recorders = int(chosen["record"] == "true")
    files = [str(CONFIG / f"{chosen['preset']}.yaml")]
    if chosen["sensors"] != "ideal":
        files.append(str(CONFIG / "sensors" / f"{chosen['sensors']}.yaml"))
    if chosen["parameters"]:
        files.append(chosen["parameters"])
    common_values = []
    if chosen["frame_prefix"]:
        text = ParameterValue(chosen["frame_prefix"], value_type=str)
        common_values.append({"frame_prefix": text})
    plant = {"time.mode": chosen["mode"], "time.recorders": recorders}
    if chosen["supply_pressure"]:
        plant["supply.pressure"] = float(chosen["supply_pressure"])
    controller = {"use_sim_time": True, "controller.recorders": recorders}
    common = {
        "package": "rodless_sim",
        "namespace": chosen["namespace"],
        "output": "screen",
        "on_exit": Shutdown(),
    }

    def node(name: str, parameters: dict) -> Node:
        return Node(
            executable=name, name=name, parameters=[*files, *common_values, parameters], **common
        )

    nodes = [node("plant", plant)]
    if chosen["controller"] == "true":
        nodes.append(node("controller", controller))
    if recorders:
        # `ros2 bag record --use-sim-time` subscribes only after the first /clock message, so its
        # bags lack the first samples; this recorder writes the same format and has them.
        output = ["--output", chosen["bag"]] if chosen["bag"] else []
        nodes.append(
            Node(executable="recorder", arguments=[*RIG_TOPICS, "/clock", *output], **common)
        )
    return nodes


def generate_launch_description() -> LaunchDescription:
    """Describe the arguments and the rig."""
    arguments = [
        DeclareLaunchArgument(name, default_value=default, choices=choices, description=text)
        for name, default, choices, text in ARGUMENTS
    ]
    return LaunchDescription([*arguments, OpaqueFunction(function=start_rig)])
