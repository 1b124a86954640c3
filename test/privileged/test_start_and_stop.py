# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Start and stop, again and again: nothing is left. `make reliability` does it a hundred times."""

import os
from pathlib import Path

import pytest
from running import until_it_says

from rodless_base.ros.shared_memory import FOLDER, LOCK_FILE, clear_dead_segments
from rodless_lab.session.processes import ProcessPlan, run_rig

CYCLES = int(os.environ.get("RODLESS_CYCLES", "2"))

# Of a start on a crowded machine, in wall-clock s.
TIMEOUT = 240.0


def segments(pids: set[int]) -> set[str]:
    """Return the shared memory that these processes have mapped."""
    mapped = set()
    for pid in pids:
        for line in Path(f"/proc/{pid}/maps").read_text(encoding="utf-8").splitlines():
            name = Path(line.split()[-1]).name
            if LOCK_FILE.fullmatch(f"{name}_el"):
                mapped.add(name)
    return mapped


@pytest.mark.slow
def test_nothing_is_left_of_start_and_stop(domain: dict[str, str], tmp_path: Path) -> None:
    """No process and no shared memory, each end with code 0; what a kill leaves is cleared."""
    for cycle in range(CYCLES):
        is_last = cycle == CYCLES - 1
        folder = tmp_path / str(cycle)
        folder.mkdir()
        with run_rig(ProcessPlan(), domain, folder) as processes:
            for name in processes.names:
                until_it_says(processes[name], "ready: realtime", TIMEOUT)
            pids = set(processes.pids.values())
            owned = segments(pids)
            if is_last:
                for name in processes.names:
                    processes[name].kill()
            else:
                assert set(processes.stop().values()) == {0}
        assert [pid for pid in pids if Path(f"/proc/{pid}").exists()] == []
        if not is_last:
            assert [name for name in owned if (FOLDER / name).exists()] == []
    for name in owned:
        lock_file = FOLDER / f"{name}_el"
        if lock_file.exists():
            # As if it had been there for longer than what is just being made.
            os.utime(lock_file, (0, 0))
    clear_dead_segments()
    assert [name for name in owned if (FOLDER / name).exists()] == []
