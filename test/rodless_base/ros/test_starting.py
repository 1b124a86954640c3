# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What a node is started with: taken, or refused in words before anything runs."""

import signal
import subprocess
from pathlib import Path

import pytest
from running import StartProcess

from rodless_lab.session.observer import TIMEOUT, Observer
from rodless_lab.session.processes import node_command


def file_for(node: str, line: str) -> str:
    """Return a parameter file with one line for ``node``."""
    return f"/**/{node}:\n  ros__parameters:\n    {line}\n"


REFUSED = {
    "out of range in a file": (
        "plant",
        file_for("plant", "supply.pressure: 3.0"),
        [],
        ["supply.pressure: 3.0", "Pa"],
    ),
    "not a number in a file": (
        "plant",
        file_for("plant", "supply.pressure: .nan"),
        [],
        ["supply.pressure: nan"],
    ),
    "a text in a file": (
        "plant",
        file_for("plant", "supply.pressure: high"),
        [],
        ["supply.pressure: 'high'"],
    ),
    "a typo in a file": (
        "plant",
        file_for("plant", "friction.forward.statik: 30.0"),
        [],
        ["friction.forward.statik: no such parameter", "did you mean friction.forward.static?"],
    ),
    "a pair that contradicts itself": (
        "plant",
        file_for("plant", "friction.forward: {static: 10, coulomb: 20}"),
        [],
        ["friction.forward.static: 10 N refused"],
    ),
    "broken YAML": ("plant", file_for("plant", "supply: ["), [], ["bad.yaml"]),
    "a list of mixed types": (
        "plant",
        file_for("plant", "valve.flow_coefficients: [1, 0.5, 0, 0, 0, 0]"),
        [],
        ["bad.yaml", "same type"],
    ),
    "a file that is not there": (
        "plant",
        None,
        ["--params-file", "nowhere.yaml"],
        ["nowhere.yaml"],
    ),
    "a negative gain on the command line": (
        "controller",
        None,
        ["-p", "controller.kp:=-1.0"],
        ["controller.kp: -1.0 refused"],
    ),
    "a typo on the command line": (
        "controller",
        None,
        ["-p", "controller.kpp:=1.0"],
        ["controller.kpp: no such parameter", "did you mean controller.kp?"],
    ),
    "a name that only begins as one of rclpy's": (
        "controller",
        None,
        ["-p", "use_sim_times:=true"],
        ["use_sim_times: no such parameter"],
    ),
    **{
        f"a time base that is neither in the {node}": (
            node,
            None,
            ["-p", "use_sim_time:=banana"],
            ["use_sim_time: 'banana' refused, must be true or false"],
        )
        for node in ("plant", "controller")
    },
    "half an argument": ("controller", None, ["-p", "controller.kp"], ["controller.kp"]),
    **{
        f"a topic of two types in the {node}": (
            node,
            None,
            ["-r", "valve/voltage:=joint_states"],
            ["valve/voltage and joint_states are one name, /joint_states,", "Float64"],
        )
        for node in ("plant", "controller")
    },
    **{
        f"two pressures of one name in the {node}": (
            node,
            None,
            ["-r", "chamber_a/pressure:=chamber_b/pressure"],
            ["chamber_b/pressure and chamber_a/pressure are one name,", "taken for the other"],
        )
        for node in ("plant", "controller")
    },
    "a controller whose commands are measured positions": (
        "controller",
        None,
        ["-r", "joint_commands:=joint_states"],
        ["joint_commands and joint_states are one name, /joint_states, so that one is taken for"],
    ),
    "a controller whose set-points are its own voltages": (
        "controller",
        None,
        ["-r", "valve/voltage:=setpoint"],
        ["setpoint and valve/voltage are one name, /setpoint, so that one is taken for the other"],
    ),
    "plant time under another topic's name": (
        "plant",
        None,
        ["-r", "/clock:=valve/voltage"],
        ["/clock and valve/voltage are one name, /valve/voltage,", "Clock and Float64"],
    ),
    "an empty list in a file": (
        "controller",
        file_for("controller", "controller.kp: []") + file_for("plant", "supply.pressure: []"),
        [],
        ["refused to start: controller.kp: [] refused, of what type an empty list is"],
    ),
    "an empty list on the command line": (
        "plant",
        None,
        ["-p", "supply.pressure:=[]"],
        ["refused to start: supply.pressure: [] refused, "],
    ),
    "an empty list for rclpy": (
        "plant",
        file_for("plant", "use_sim_time: []"),
        [],
        ["refused to start: use_sim_time: [] refused, "],
    ),
    "an unknown ROS argument": ("controller", None, ["--parameters", "x"], ["--parameters"]),
}


@pytest.mark.parametrize(("node", "file", "arguments", "words"), REFUSED.values(), ids=REFUSED)
def test_a_bad_start_ends_with_1_and_says_why(
    domain: dict[str, str],
    tmp_path: Path,
    node: str,
    file: str | None,
    arguments: list[str],
    words: list[str],
) -> None:
    """The process ends by itself, its last words on stderr name the culprit, and no traceback."""
    files = []
    if file is not None:
        files = [tmp_path / "bad.yaml"]
        files[0].write_text(file)
    ended = subprocess.run(
        node_command(node, files) + arguments,
        env=domain,
        capture_output=True,
        text=True,
        timeout=TIMEOUT,
        check=False,
    )
    assert ended.returncode == 1, ended.stdout + ended.stderr
    last = ended.stderr.strip().splitlines()[-1]
    assert last.startswith("refused to start: ")
    for word in words:
        assert word in last
    assert "Traceback" not in ended.stdout + ended.stderr


def test_a_file_in_plain_yaml_is_taken(
    start_process: StartProcess, observer: Observer, tmp_path: Path
) -> None:
    """Integers stand for reals, names may be nested, and parameters of rclpy are nobody's typo."""
    path = tmp_path / "plant.yaml"
    path.write_text(
        "/**/plant:\n"
        "  ros__parameters:\n"
        "    supply.pressure: 600000\n"
        "    friction: {forward: {static: 30, coulomb: 11}}\n"
        "    valve.flow_coefficients: [1, 0, 0, 0, 0, 0]\n"
        "    use_sim_time: false\n"
        "    start_type_description_service: false\n"
        "    qos_overrides./parameter_events.publisher.depth: 100\n"
    )
    expected = {"supply.pressure": 600_000.0, "friction.forward.static": 30.0}
    with start_process(node_command("plant", [path])) as plant:
        assert observer.get_parameters("/plant", list(expected)) == expected
        plant.signal(signal.SIGINT)
        assert plant.wait() == 0


def test_a_value_on_the_command_line_wins_over_the_file(
    start_process: StartProcess, observer: Observer, tmp_path: Path
) -> None:
    """`-p` after `--params-file`, as with any node."""
    path = tmp_path / "controller.yaml"
    path.write_text(file_for("controller", "controller: {kp: 100, ki: 50}"))
    command = [*node_command("controller", [path], "later"), "-p", "controller.kp:=200"]
    with start_process(command) as controller:
        names = ["controller.kp", "controller.ki"]
        assert list(observer.get_parameters("/later/controller", names).values()) == [200.0, 50.0]
        controller.signal(signal.SIGINT)
        assert controller.wait() == 0
