# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A soak in small: the nodes run, and what would be wrong in a long one is seen."""

import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from extent import extensive
from no_room import fill_up
from quiet_stop import Quiet

from rodless_control import PidParameters, references
from rodless_lab.cli.soak import main
from rodless_lab.simulation.closed_loop import ClosedLoopTrace, closed_loop
from rodless_lab.soak.balance import balance
from rodless_lab.soak.memory import growth
from rodless_lab.soak.report import complaints, summary
from rodless_sim import RigParameters

PERIOD = 1e-3


@pytest.fixture(scope="module")
def run() -> ClosedLoopTrace:
    """Ten seconds of a sine."""
    sine = references.sine(0.1, 0.02, 0.5, at=0.5)
    return closed_loop(RigParameters(), PidParameters(), sine, 10.0, PERIOD)


def test_a_balance_closes(run: ClosedLoopTrace) -> None:
    """To 1e-6 of what went through the chambers; less energy stays than has come in."""
    found = balance(RigParameters(), run, PERIOD)
    assert found.gap < 1e-6 * (1.0 + 5.0)
    assert found.turnover > 1000.0
    assert 0.0 < found.inflow < found.turnover


@pytest.mark.parametrize("name", ["pressure_a", "position", "voltage"])
def test_a_balance_of_a_wrong_run_does_not_close(run: ClosedLoopTrace, name: str) -> None:
    """A hundredth more pressure, motion or voltage than there was."""
    columns = ("position", "pressure_a", "pressure_b", "voltage")
    wrong = SimpleNamespace(**{one: getattr(run, one) for one in columns})
    setattr(wrong, name, 1.01 * getattr(run, name))
    assert balance(RigParameters(), wrong, PERIOD).gap > 1e-4


def test_growth_is_that_of_the_settled_part() -> None:
    """What fills in the first quarter is none; 1 MB in 100 s is 36 MB/h; three readings tell."""
    settled = [(float(k), 200.0) for k in range(300)]
    fills = [(float(k), 50.0 + k) for k in range(75)]
    assert growth(fills + settled[75:]) == pytest.approx(0.0, abs=1e-6)
    assert growth([(float(k), 0.01 * k) for k in range(300)]) == pytest.approx(36.0)
    assert math.isnan(growth([(0.0, 1.0), (5.0, 1.0)]))


@extensive
@pytest.mark.ros
@pytest.mark.slow
def test_a_short_soak_finds_nothing_wrong() -> None:
    """Both modes run over DDS; in lock-step no sample is lost, none other than without nodes."""
    from rodless_lab.soak.ros.soak import soak_lockstep, soak_realtime  # noqa: PLC0415  needs ROS

    said: list[str] = []
    realtime = soak_realtime(3.0, said.append, lambda: None)
    lockstep = soak_lockstep(6000, said.append, lambda: None)
    assert realtime.samples > 50
    assert lockstep.samples >= 1900
    assert lockstep.lost == 0
    assert lockstep.differing == 0
    for found in (realtime, lockstep):
        assert found.memory.keys() == {"plant", "controller"}
        assert f"| samples | {found.samples} |" in summary(found)
    assert said


def test_what_is_wrong_is_named(run: ClosedLoopTrace) -> None:
    """Losses, other numbers, an open balance and growing memory: a line each."""
    from rodless_lab.soak.ros.soak import Soak  # noqa: PLC0415  needs ROS

    good = balance(RigParameters(), run, PERIOD)
    flat = {"plant": [(10.0 * k, 200.0) for k in range(100)]}
    grows = {"plant": [(10.0 * k, 200.0 + 0.1 * k) for k in range(100)]}
    assert complaints(Soak("lockstep", 1000.0, 10, memory=flat, balance=good)) == []
    bad = Soak(
        "lockstep",
        1000.0,
        10,
        lost=3,
        differing=7,
        memory=grows,
        balance=good._replace(gained=good.gained + np.nan),
    )
    text = " ".join(complaints(bad))
    for word in ("3 of 10 samples lost", "7 samples differ", "does not close", "36.0 MB/h"):
        assert word in text


@pytest.mark.ros
def test_what_did_not_come_in_time_is_shown_and_no_failure(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """A busy machine can be late; the valve closes, as it should. The help says what counts."""
    from rodless_lab.soak.ros.soak import Soak  # noqa: PLC0415  needs ROS

    late = {"/plant commands lost": "5", "/controller positions lost": "0"}
    found = Soak("real time", 1000.0, 10, memory={"plant": [(1.0, 200.0)]}, faults=late)
    assert complaints(found) == []
    assert "| /plant commands lost | 5 |" in summary(found)
    with pytest.raises(SystemExit):
        main(["--help"], Quiet())
    said = " ".join(capsys.readouterr().out.split())
    assert "0 no sample lost" in said
    assert "Commands and positions that did not come in time are shown alone" in said


@pytest.mark.ros
def test_a_report_that_finds_the_disk_full_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """After the hour: what it has found is printed all the same, and the code is 2."""
    from rodless_lab.soak.ros import soak  # noqa: PLC0415  needs ROS

    found = soak.Soak("lockstep", 1.0, 10, memory={"plant": [(1.0, 200.0)]})
    monkeypatch.setattr(soak, "soak_lockstep", lambda *_: found)
    fill_up(monkeypatch)
    output = tmp_path / "soak.md"
    assert main(["--seconds", "0", "--steps", "10000", "--output", str(output)], Quiet()) == 2
    said = capsys.readouterr()
    assert said.out == summary(found) + "\n"
    assert said.err == f"{output}: cannot be written: No space left on device\n"
    assert not output.exists()


@pytest.mark.parametrize("steps", ["1", "9999"])
def test_too_few_steps_to_tell_are_refused(steps: str, capsys: pytest.CaptureFixture[str]) -> None:
    """A sound rig would fail: what its first steps leave open is a large share of so little."""
    with pytest.raises(SystemExit, match="2"):
        main(["--seconds", "0", "--steps", steps], Quiet())
    said = capsys.readouterr().err
    assert f"{steps} steps are too few to tell whether the balance closes: at least 10000" in said


@pytest.mark.parametrize("seconds", ["0.0001", "9.9"])
def test_too_few_seconds_to_tell_are_refused(
    seconds: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """It would pass: memory is read once, and says nothing of how it grows."""
    with pytest.raises(SystemExit, match="2"):
        main(["--seconds", seconds, "--steps", "0"], Quiet())
    said = capsys.readouterr().err
    assert f"{seconds} s are too short to tell anything of memory: at least 10" in said
