# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A network without loopback, as of a container without one: nodes cannot find each other in it.

Needs root: `make reliability` runs it, CI does not.
"""

import subprocess
import sys
from pathlib import Path

import pytest

from rodless_base.ros.profiles import PROFILE_VARIABLES
from rodless_base.ros.shared_memory import RANGE

TIMEOUT = 120.0
SESSION = "from rodless_lab.harness import RigSession; RigSession().__enter__()"
RODLESS = "from rodless_lab.cli.main import main; main()"
SETTINGS = dict.fromkeys((RANGE, *PROFILE_VARIABLES.values()), "")


@pytest.mark.parametrize(
    "command", [[SESSION], [RODLESS, "rig"], [RODLESS, "view", "--rig", "--port", "0"]]
)
def test_a_missing_loopback_is_told_at_once(
    domain: dict[str, str], tmp_path: Path, command: list[str]
) -> None:
    """Before anything starts, with what to do; nothing waits for a node that cannot be heard."""
    done = subprocess.run(
        ["unshare", "-n", sys.executable, "-c", *command],
        env={**domain, **SETTINGS},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=TIMEOUT,
        check=False,
    )
    assert done.returncode in (1, 2)
    said = done.stderr.splitlines()[-1]
    assert "127.0.0.1 cannot be reached (Network is unreachable)" in said
    assert "ip link set lo up" in said
