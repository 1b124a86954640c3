# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Start the plant and the controller: `ros2 launch rodless_sim rig.launch.py preset:=paper`."""

import atexit
import shutil
import signal
import tempfile
from pathlib import Path

from ament_index_python.packages import (
    PackageNotFoundError,
    get_package_prefix,
    get_package_share_directory,
)
from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.events.process import ProcessExited
from launch.logging import get_logger
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from rodless_base.parameter_file import read_parameter_file
from rodless_base.topics import FURTHER_TOPICS, RIG_TOPICS, ROS_CLOCK, TEMPERATURES
from rodless_base.written_number import written_number
from rodless_lab.session.domain import namespace_of_nodes
from rodless_lab.session.file_parameters import (
    check_together,
    own_parameters,
    reference_maximum,
)
from rodless_lab.session.launch_arguments import misspelt
from rodless_lab.session.processes import clock_of_its_own, write_parameters
from rodless_sim import ParameterError, RigParameters, ScenarioError
from rodless_sim.cylinder_series import sizes
from rodless_sim.description import robot_description
from rodless_sim.instruments.instruments import SENSORS
from rodless_sim.physics.heat import ENERGY_BALANCE
from rodless_sim.scenario import scenario_parameter

CONFIG = Path(get_package_share_directory("rodless_sim"), "config")
PRESETS = sorted(file.stem for file in CONFIG.glob("*.yaml"))
BOOL = ["true", "false"]
MODES = ["", "realtime", "lockstep"]
LEVELS = ["debug", "info", "warn", "error", "fatal"]

# Where launch_ros keeps the namespace of PushRosNamespace.
PUSHED = "ros_namespace"

# Name, default, choices, meaning.
ARGUMENTS = (
    ("preset", "paper", PRESETS, "parameter preset"),
    (
        "sensors",
        "preset",
        ["preset", *(name.replace("-", "_") for name in SENSORS)],
        "instruments: the preset's, ideal, or the paper's",
    ),
    ("parameters", "", None, "parameter file on top of those"),
    ("supply_pressure", "", None, "supply pressure in Pa, absolute; empty: the preset's"),
    ("cylinder", "", None, "model of the CY3R series, such as CY3R32-500; empty: the preset's"),
    ("scenario", "", None, "scenario file, or the name of one of the package, such as leak"),
    ("truth", "false", BOOL, "publish what is true, too, on truth/..."),
    ("raw", "false", BOOL, "publish the voltages of the instruments, too, on raw/voltages"),
    ("controller", "true", BOOL, "start our controller; false: the plant waits for yours"),
    ("namespace", "", None, "namespace of all nodes"),
    ("frame_prefix", "", None, "put before frame_ids and the joint's name: left/"),
    ("mode", "", MODES, "what drives plant time; empty: the parameters', by default realtime"),
    ("speed", "", None, "plant s per wall-clock s in realtime; empty: the preset's"),
    (
        "publish_clock",
        "auto",
        ["auto", *BOOL],
        "publish plant time on /clock; auto: as the parameters say, by default unless there is a "
        "namespace, which has its own clock",
    ),
    ("description", "false", BOOL, "publish robot_description and transforms, as RViz wants them"),
    ("use_composition", "false", BOOL, "run plant and controller in one process"),
    ("log_level", "info", LEVELS, "least severe messages that the nodes log"),
    (
        "record",
        "auto",
        ["auto", *BOOL],
        "record a bag from the first sample on; auto: if bag:= names one",
    ),
    ("bag", "", None, "folder of that bag; empty: named after the time"),
)


def start_rig(context: LaunchContext) -> list[Node]:
    """Return the nodes; the launch ends when any does, so that a dead node is seen."""
    chosen = chosen_arguments(context)
    parameters = parameter_files(chosen)
    common = {
        "package": "rodless_sim",
        "namespace": chosen["namespace"],
        "output": "screen",
        "on_exit": end_with_it,
        "ros_arguments": [
            "--log-level",
            chosen["log_level"],
            *clock_of_its_own(chosen["namespace"], plant_values(parameters, chosen["namespace"])),
        ],
    }
    described = chosen["description"] == "true"
    others = [state_publisher(parameters, chosen["namespace"])] if described else []
    with_controller = chosen["controller"] == "true"
    recorded = chosen["record"] == "true"
    if with_controller and chosen["use_composition"] == "true":
        # One process records itself, at a fraction of what it costs from beside it.
        record = ["--record", *filter(None, [chosen["bag"]])] if recorded else []
        rig = Node(executable="rig", arguments=record, parameters=parameters, **common)
        return [rig, *others]
    names = ["plant", "controller"] if with_controller else ["plant"]
    nodes = [Node(executable=name, name=name, parameters=parameters, **common) for name in names]
    if recorded:
        # `ros2 bag record --use-sim-time` subscribes only after the first /clock message, so its
        # bags lack the first samples; this recorder writes the same format and has them.
        output = ["--output", chosen["bag"]] if chosen["bag"] else []
        topics = [ROS_CLOCK, *further_topics(parameters, chosen["namespace"]), *RIG_TOPICS]
        nodes.append(Node(executable="recorder", arguments=[*topics, *output], **common))
    return [*nodes, *others]


def chosen_arguments(context: LaunchContext) -> dict[str, str]:
    """Return the arguments by name; logs a warning of one that is likely misspelt.

    The namespace is the full one: below that of a PushRosNamespace around this file.
    """
    chosen = {name: LaunchConfiguration(name).perform(context) for name, *_ in ARGUMENTS}
    for line in misspelt(context.launch_configurations, chosen, Path(__file__).name):
        get_logger("rodless_sim").warning(line)
    if chosen["record"] == "auto":
        chosen["record"] = "true" if chosen["bag"] else "false"
    pushed = context.launch_configurations.get(PUSHED, "")
    chosen["namespace"] = namespace_of_nodes(pushed, chosen["namespace"])
    return chosen


def state_publisher(files: list[str], namespace: str) -> Node:
    """Return what makes transforms of joint_states, for the rig that the files describe.

    Raises RuntimeError where it is not installed.
    """
    try:
        get_package_prefix("robot_state_publisher")
    except PackageNotFoundError:
        raise RuntimeError(
            "description:=true needs robot_state_publisher, which is not installed: "
            "apt install ros-$ROS_DISTRO-robot-state-publisher"
        ) from None
    rig = RigParameters(plant_values(files, namespace))
    return Node(
        package="robot_state_publisher",
        executable="robot_state_publisher",
        namespace=namespace,
        output="screen",
        parameters=[{"robot_description": robot_description(rig)}],
        on_exit=end_with_it,
    )


def further_topics(files: list[str], namespace: str) -> list[str]:
    """Return what the plant publishes beside the rig's own topics."""
    values = plant_values(files, namespace)
    on = {"raw": values.get("sensors.publish_raw"), "truth": values.get("sensors.publish_truth")}
    heated = values.get("chambers.thermodynamics") == ENERGY_BALANCE
    asked_for = [topic for topic in FURTHER_TOPICS if on[topic.partition("/")[0]]]
    return [*(TEMPERATURES.values() if heated else ()), *asked_for]


def plant_values(files: list[str], namespace: str) -> dict[str, object]:
    """Return what the files say of the plant; later ones win."""
    values: dict[str, object] = {}
    for file in files:
        own = read_parameter_file(file, "plant", RigParameters.foreign, namespace)
        values.update(own)
    return values


def parameter_files(chosen: dict[str, str]) -> list[str]:
    """Return the files that give the nodes their parameters; later ones win.

    What no argument asks for does not stand above the user's file. Raises RuntimeError for an
    argument that is no number, and a user's file that is none or that a node would refuse.
    """
    files = [CONFIG / f"{chosen['preset']}.yaml"]
    if chosen["sensors"] != "preset":
        files.append(CONFIG / "sensors" / f"{chosen['sensors']}.yaml")
    folder = Path(tempfile.mkdtemp(prefix="rodless_sim-"))
    atexit.register(remove, folder)
    if chosen["namespace"].strip("/"):
        # Of several rigs, /clock can be only one's.
        own_clock = {"plant": {"time.publish_clock": False}}
        files.append(write_parameters(folder / "namespace.yaml", own_clock))
    arguments = parameters_of_arguments(chosen)
    if chosen["parameters"]:
        found = parameters_of_file(chosen, files[0], arguments)
        files.append(write_parameters(folder / "of_file.yaml", found))
    files.append(write_parameters(folder / "arguments.yaml", arguments))
    return [str(file) for file in files]


def remove(folder: Path) -> None:
    """Remove ``folder`` as the launch ends; Ctrl-C again has nothing left to end."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    shutil.rmtree(folder, ignore_errors=True)


def parameters_of_file(
    chosen: dict[str, str], preset: Path, arguments: dict[str, dict[str, object]]
) -> dict[str, dict[str, object]]:
    """Return what the user's file gives to each node, as `rodless rig --parameters` takes it.

    It stands on the preset and under the ``arguments``, which keep a travel of its own within that
    of a cylinder. Raises RuntimeError for what `rodless rig` refuses.
    """
    file = Path(chosen["parameters"])
    if not file.is_file():
        raise RuntimeError(f"parameters:={file}: no such file")
    nodes = ["plant", "controller"] if chosen["controller"] == "true" else ["plant"]
    try:
        found = own_parameters(file, chosen["namespace"])
        if chosen["cylinder"]:
            maximum = reference_maximum(stroke(chosen["cylinder"]), found)
            arguments["controller"]["reference.maximum"] = maximum
        check_together(file, preset, found, {node: arguments[node] for node in nodes})
    except ParameterError as error:
        raise RuntimeError(f"parameters:={error}") from None
    return found


def parameters_of_arguments(chosen: dict[str, str]) -> dict[str, dict[str, object]]:
    """Return what the launch arguments say, by node."""
    plant: dict[str, object] = {"time.mode": chosen["mode"]} if chosen["mode"] else {}
    controller: dict[str, object] = {"use_sim_time": True}
    if chosen["record"] == "true":
        plant["time.recorders"] = controller["controller.recorders"] = 1
    if chosen["publish_clock"] != "auto":
        plant["time.publish_clock"] = chosen["publish_clock"] == "true"
    for argument, name in (("supply_pressure", "supply.pressure"), ("speed", "time.speed")):
        if chosen[argument]:
            plant[name] = number(argument, chosen[argument], name)
    # The presets and sensor files say nothing of these; a file of the user's may.
    plant |= {
        f"sensors.publish_{name}": True for name in ("truth", "raw") if chosen[name] == "true"
    }
    plant |= scenario_of_argument(chosen["scenario"])
    if chosen["cylinder"]:
        plant["cylinder.model"] = chosen["cylinder"]
        controller["reference.maximum"] = stroke(chosen["cylinder"])
    prefix = {"frame_prefix": chosen["frame_prefix"]} if chosen["frame_prefix"] else {}
    return {"plant": {**plant, **prefix}, "controller": {**controller, **prefix}}


def scenario_of_argument(given: str) -> dict[str, str]:
    """Return what has the plant follow a scenario; raises RuntimeError for one that is none."""
    try:
        return scenario_parameter(given) if given else {}
    except ScenarioError as error:
        raise RuntimeError(f"scenario:={given}: {error}") from None


def number(argument: str, text: str, parameter: str) -> float:
    """Return the number that an argument is; RuntimeError where its parameter takes no such one."""
    try:
        value = written_number(text)
        RigParameters.DECLARATIONS[parameter].check(value)
    except ParameterError as error:
        raise RuntimeError(f"{argument}:={text}: {error}") from None
    except ValueError:
        raise RuntimeError(f"{argument}:={text}: not a number") from None
    return value


def stroke(model: str) -> float:
    """Return the stroke of a cylinder in m; raises RuntimeError for a model that is none."""
    try:
        return sizes(model).stroke
    except ParameterError as error:
        raise RuntimeError(f"cylinder:={model}: {error}") from None


def end_with_it(event: ProcessExited, context: LaunchContext) -> Shutdown:
    """End the launch with a node; raises, for an exit code other than 0, if the node has failed."""
    if event.returncode and not context.is_shutdown:
        raise RuntimeError(f"{event.process_name} has ended with exit code {event.returncode}")
    return Shutdown(reason=f"{event.process_name} has ended")


def generate_launch_description() -> LaunchDescription:
    """Describe the arguments and the rig."""
    arguments = [
        DeclareLaunchArgument(name, default_value=default, choices=choices, description=text)
        for name, default, choices, text in ARGUMENTS
    ]
    return LaunchDescription([*arguments, OpaqueFunction(function=start_rig)])
