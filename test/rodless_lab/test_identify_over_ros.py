# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A rig whose chambers nobody has told: driven, recorded and identified with the commands alone."""

import signal
from pathlib import Path

import pytest
from extent import extensive
from running import StartProcess

from rodless_lab.bags.reader import read_bag
from rodless_lab.session.observer import TIMEOUT
from rodless_sim import RigParameters

pytestmark = pytest.mark.slow

HIDDEN = {
    "cylinder.dead_volume_a": 11e-6,
    "cylinder.dead_volume_b": 24e-6,
    "valve.gap_height": 5e-6,
    "supply.pressure": 601325.0,
}
TOPICS = "joint_states chamber_a/pressure chamber_b/pressure supply/pressure valve/voltage /clock"


def write_start(path: Path) -> Path:
    """Write what the rig is and nobody knows, its time, and where the carriage starts."""
    values = {
        **HIDDEN,
        "cylinder.initial_position": 0.06,
        "time.mode": "lockstep",
        "time.recorders": 1,
    }
    lines = "".join(f"    {name}: {value}\n" for name, value in values.items())
    path.write_text(f"/**/plant:\n  ros__parameters:\n{lines}", encoding="utf-8")
    return path


@extensive
def test_chambers_are_found_again(rodless: StartProcess, tmp_path: Path) -> None:
    """All four parameters lie in the 95 % intervals said, from a bag of noisy sensors.

    The noise is always the same one, and the file written loads.
    """
    start, bag = write_start(tmp_path / "rig.yaml"), tmp_path / "bag"
    found = tmp_path / "found.yaml"
    options = ("--without-controller", "--sensors", "data-sheet", "--parameters", str(start))
    with (
        rodless("rig", *options) as rig,
        rodless("record", *TOPICS.split(), "--output", str(bag)) as recorder,
    ):
        with rodless("drive", "chambers", "--recorders", "1") as driver:
            assert driver.wait(TIMEOUT * 5.0) == 0, driver.output
        recorder.signal(signal.SIGINT)
        assert recorder.wait(TIMEOUT) == 0, recorder.output
        rig.signal(signal.SIGINT)
        assert rig.wait(TIMEOUT) == 0, rig.output
    recorded = read_bag(bag)
    assert recorded["/joint_states"].log_time[0] == 0
    assert recorded["/valve/voltage"].fields["data"].ravel()[0] == 5.08

    with rodless("identify", "chambers", str(bag), "--output", str(found)) as identify:
        assert identify.wait(TIMEOUT) == 0, identify.output
    identified = RigParameters.from_file(found)
    lines = found.read_text(encoding="utf-8").splitlines()
    for name, hidden in HIDDEN.items():
        (place,) = (k for k, line in enumerate(lines) if line.strip().startswith(f"{name}:"))
        low, high = lines[place - 1].split("95 % from ")[1].split(" to ")
        assert float(low) <= hidden <= float(high.split()[0].strip(";")), name
        assert identified.number(name) == pytest.approx(hidden, rel=0.05), name
