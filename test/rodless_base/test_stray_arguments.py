# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Arguments that stand before ``--ros-args`` reach nobody: a node does not start with them."""

import subprocess

import pytest

from rodless_lab.session.processes import node_command

# For a process to end, in wall-clock s.
TIMEOUT = 300.0


def run(node: str, *arguments: str) -> "subprocess.CompletedProcess[str]":
    """Start a node with these arguments, which must end by itself."""
    command = [*node_command(node, arguments=arguments), "-p", "supply.pressure:=-1.0"]
    return subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT, check=False)


@pytest.mark.ros
@pytest.mark.parametrize("node", ["plant", "controller"])
@pytest.mark.parametrize(
    "arguments",
    [
        ["-p", "time.mode:=lockstep"],
        ["--params-file", "mine.yaml"],
        ["-r", "__ns:=/left"],
        ["joint_states:=elsewhere"],
        ["extra", "--bogus"],
    ],
    ids=["parameter", "file", "remapping", "rule", "words"],
)
def test_a_node_refuses_what_does_not_follow_ros_args(node: str, arguments: list[str]) -> None:
    """In one line with what was given and the way out, code 2; they had no effect, and no word."""
    ended = run(node, *arguments)
    assert ended.returncode == 2
    given = " ".join(arguments)
    assert ended.stderr == (
        f"{node}: error: {given} refused: parameters, files and remappings follow --ros-args; "
        f"see {node} --help\n"
    )
    assert not ended.stdout


@pytest.mark.ros
@pytest.mark.parametrize("node", ["plant", "controller"])
def test_the_help_of_a_node_says_where_its_parameters_stand(node: str) -> None:
    """And starts no rig."""
    ended = run(node, "--help")
    assert ended.returncode == 0
    assert f"{node} [-h] [--ros-args [-p NAME:=VALUE]" in ended.stdout
    assert not ended.stderr


@pytest.mark.ros
def test_what_follows_ros_args_is_left_to_ros() -> None:
    """The plant reads its parameters there and refuses a pressure below zero by itself."""
    ended = run("plant")
    assert ended.returncode == 1
    assert "supply.pressure" in ended.stderr
