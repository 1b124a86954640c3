# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A rig of another account: found over the network; what it sends over shared memory is lost.

A private mount over /dev/shm does here what the permissions of two accounts do. Needs root:
`make reliability` runs it, CI does not.
"""

import sys
from pathlib import Path

from running import StartProcess, until_it_says

from rodless_base.ros.profiles import PROFILE_VARIABLES
from rodless_base.ros.shared_memory import RANGE

TIMEOUT = 240.0
APART = ["unshare", "-m", "bash", "-c", 'mount -t tmpfs none /dev/shm; exec "$@"', "bash"]
RODLESS = [sys.executable, "-c", "from rodless_lab.cli.main import main; main()"]
SETTINGS = dict.fromkeys((RANGE, *PROFILE_VARIABLES.values()), "")


def test_what_does_not_arrive_is_told(
    start_process: StartProcess, domain: dict[str, str], tmp_path: Path
) -> None:
    """No second rig starts beside it, nobody is told to start one, and no bag passes for whole."""
    del domain
    rig_alone = [*RODLESS, "rig", "--lockstep", "--without-controller"]
    with start_process(rig_alone, "rig", environment=SETTINGS) as rig:
        until_it_says(rig, "ready: preset paper", TIMEOUT)
        for verb, code, said in (
            (["rig"], 2, "of which nothing arrives: stop that rig"),
            (["status"], 1, "/joint_states of ROS domain "),
            (["drive", "friction"], 1, "/joint_states: published, but nothing arrives"),
        ):
            with start_process([*APART, *RODLESS, *verb], "other", environment=SETTINGS) as other:
                assert other.wait(TIMEOUT) == code
                assert said in other.output
        record = [*APART, *RODLESS, "record", "-o", str(tmp_path / "bag")]
        with start_process(record, "recorder", environment=SETTINGS) as recorder:
            until_it_says(recorder, "published, but nothing arrives, probably from", TIMEOUT)
            recorder.ask_to_stop()
            assert recorder.wait(TIMEOUT) == 1
            assert "FASTDDS_BUILTIN_TRANSPORTS=UDPv4" in recorder.output
        view = [*APART, *RODLESS, "view", "--port", "0", "--folder", str(tmp_path)]
        with start_process(view, "view", environment=SETTINGS) as page:
            until_it_says(page, "/joint_states: published, but nothing arrives", TIMEOUT)
            page.ask_to_stop()
            assert page.wait(TIMEOUT) == 0


def test_a_rig_in_real_time_is_heard(start_process: StartProcess, domain: dict[str, str]) -> None:
    """It talks over UDP, and so does whoever asks it for something."""
    del domain
    with start_process([*RODLESS, "rig"], "rig", environment=SETTINGS) as rig:
        until_it_says(rig, "ready: preset paper", TIMEOUT)
        for verb in (["status"], ["move", "40"]):
            with start_process([*APART, *RODLESS, *verb], "other", environment=SETTINGS) as other:
                assert other.wait(TIMEOUT) == 0, other.output
