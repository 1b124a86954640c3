# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Shared memory that is full, too small or cannot be written: a private mount over /dev/shm.

Needs root: `make reliability` runs it, CI does not.
"""

import subprocess
import sys

import pytest
from running import StartProcess, until_it_says

from rodless_base.ros.profiles import PROFILE_VARIABLES
from rodless_base.ros.shared_memory import RANGE
from rodless_lab.session.processes import node_command

TIMEOUT = 240.0

# Mounts before the command in its place runs; "$@" is that.
FULL = "mount -t tmpfs -o size=16k none /dev/shm; head -c 16k /dev/zero > /dev/shm/fill; "
SMALL = "mount -t tmpfs -o size=700k none /dev/shm; "
READ_ONLY = "mount -t tmpfs -o ro,size=4m none /dev/shm; "

# As `ros2 run` starts nodes: with shared memory.
SETTINGS = {RANGE: "SUBNET", **dict.fromkeys(PROFILE_VARIABLES.values(), "")}


def mounted(mount: str, command: list[str]) -> list[str]:
    """Return the command line that runs ``command`` with that mount, which nobody else sees."""
    return ["unshare", "-m", "bash", "-c", mount + 'exec "$@"', "bash", *command]


def test_full_shared_memory_is_named(domain: dict[str, str]) -> None:
    """The plant ends with 1 and says what is full, before ROS dies of it without a word."""
    done = subprocess.run(
        mounted(FULL, node_command("plant")),
        env={**domain, **SETTINGS},
        capture_output=True,
        text=True,
        timeout=TIMEOUT,
        check=False,
    )
    assert done.returncode == 1
    assert "/dev/shm: 0 kB free" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("mount", [SMALL, READ_ONLY], ids=["small", "read-only"])
def test_without_shared_memory_the_rig_runs(start_process: StartProcess, mount: str) -> None:
    """It says so, and plant and controller find each other over UDP."""
    command = [sys.executable, "-c", "from rodless_lab.cli.main import main; main()", "rig"]
    with start_process(
        mounted(mount, command), "rig", environment=dict.fromkeys(SETTINGS, "")
    ) as rig:
        until_it_says(rig, "ready: preset paper", TIMEOUT)
        if mount == SMALL:
            assert "going without" in rig.output
