# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The verbs without a rig: help, bad arguments, the screen of `rodless status`."""

import re
import shlex
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from extent import some_of
from quiet_stop import Quiet

from rodless_lab.cli import rig as rig_verb
from rodless_lab.cli import status as status_verb
from rodless_lab.cli.main import VERBS
from rodless_lab.cli.status import screen
from rodless_lab.session.status import NodeStatus, RigStatus

# Verbs that talk to a running rig.
EXPLAINED = {
    *("move", "set", "get", "fault", "status"),
    *("pause", "resume", "reset", "enable", "disable"),
}

# Runs `rodless` where neither ROS nor psutil is installed.
BARE = (
    "import sys\n"
    "for name in ('rclpy', 'std_msgs', 'sensor_msgs', 'diagnostic_msgs', 'std_srvs',\n"
    "             'rcl_interfaces', 'builtin_interfaces', 'rosgraph_msgs', 'psutil'):\n"
    "    sys.modules[name] = None\n"
    "from rodless_lab.cli.main import main\n"
    "main()\n"
)


def run_bare(*arguments: str, **streams: Any) -> subprocess.CompletedProcess[str]:
    """Run `rodless` with ``arguments``."""
    return subprocess.run(
        [sys.executable, "-c", BARE, *arguments],
        text=True,
        timeout=60,
        check=False,
        **(streams or {"capture_output": True}),
    )


@pytest.mark.slow
@pytest.mark.parametrize("verb", some_of(list(VERBS), 3))
def test_help_needs_no_ros(verb: str) -> None:
    """It says what the verb does; those that talk to a rig explain their exit codes."""
    shown = run_bare(verb, "--help")
    assert shown.returncode == 0, shown.stderr
    assert f"usage: rodless {verb}" in shown.stdout
    if verb in EXPLAINED:
        assert "Exit code: 0" in " ".join(shown.stdout.split())


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("move", "MM"),
        ("move there", "'there' is not a length in mm"),
        ("move nan", "'nan' is not a length in mm"),
        ("move 58 --timeout 0", "'0' is not a positive number of seconds"),
        ("set", "NAME=VALUE"),
        ("set supply.pressure", "'supply.pressure' is not NAME=VALUE"),
        ("set =5", "'=5' is not NAME=VALUE"),
        ("set a=1 a=2", "a: refused, given twice, as 1 and 2"),
        ("set a=\udcff", "'a=\\udcff' is not text in UTF-8"),
        ("get \udcff", "'\\udcff' is not text in UTF-8"),
        ("record -o b\udcff", "'b\\udcff' is not text in UTF-8"),
        ("get ''", "'' is no parameter's name"),
        ("get --timeout -1", "'-1' is not a positive number of seconds"),
        ("record -o ''", "'' refused, no file has this path"),
        ("rig --record ''", "'' refused, no file has this path"),
        ("rig --parameters missing.yaml", "--parameters missing.yaml: no such file"),
        ("rig --parameters .", "--parameters .: no file, but something else"),
        ("rig --record .", "--record .: exists already; a bag is never written over"),
        ("rig --record /proc/bag", "--record /proc/bag: cannot be written: "),
        ("rig --cylinder CY3R7-1", "the series has the bores"),
        (f"rig --parameters {'x' * 300}", "it has a name of more than 255 bytes"),
        (f"rig --record {'x' * 300}", "it has a name of more than 255 bytes"),
        ("view --port inf", "'inf' is not a port from 0 to 65535"),
        (f"laws --rigs {'9' * 5000}", "is not a positive whole number"),
        ("pause 'a\nb'", "unrecognized arguments: 'a b'"),
        ("pause ''", "unrecognized arguments: ''"),
        ("fault valve.offset", "valve.offset: refused, no value; give valve.offset=VALUE"),
        ("fault --clear valve.offset=1", "valve.offset=1: refused, --clear takes names"),
        (
            "fault valve.offset=1 fault.valve.offset=2",
            "error: valve.offset: refused, given twice, as 1",
        ),
        ("fault --clear valve.offset valve.offset", "error: valve.offset: refused, given twice; "),
        ("pause now", "unrecognized arguments: now"),
        ("status --timeout soon", "'soon' is not a positive number of seconds"),
    ],
)
def test_bad_arguments_are_named(arguments: str, words: str) -> None:
    """Exit code 2 and one line, with the argument and the way to the help."""
    run = run_bare(*shlex.split(arguments))
    assert run.returncode == 2
    assert words in run.stderr
    assert re.fullmatch(r"rodless( \w+)?: error: .+; see rodless( \w+)? --help\n", run.stderr)


@pytest.mark.parametrize("arguments", ["--help", "move --help"])
def test_help_that_cannot_be_written_is_no_success(arguments: str) -> None:
    """Exit code 1 and a line, as where a verb's own output gets lost."""
    with Path("/dev/full").open("w") as full:
        run = run_bare(*arguments.split(), stdout=full, stderr=subprocess.PIPE)
    assert run.returncode == 1
    assert run.stderr == "standard output: cannot be written: No space left on device\n"


@pytest.mark.parametrize("arguments", ["move 58", "set a=1", "status"])
def test_without_ros_one_line_says_how_to_get_it(arguments: str) -> None:
    """Exit code 2 and no traceback."""
    run = run_bare(*arguments.split())
    assert run.returncode == 2
    assert "rclpy is missing: source a ROS 2 distribution" in run.stderr
    assert "Traceback" not in run.stderr
    assert len(run.stderr.splitlines()) == 1


@pytest.mark.parametrize("command", [status_verb, rig_verb], ids=["status", "rig"])
@pytest.mark.parametrize(
    ("domain", "namespace", "line"),
    [
        ("7", "a b", "--namespace 'a b': letters, digits, _ and / only, no digit after a /"),
        ("abc", "a", "ROS_DOMAIN_ID='abc': must be a whole number from 0 to 232"),
        ("999", "a", "ROS_DOMAIN_ID='999': must be a whole number from 0 to 232"),
    ],
)
def test_a_domain_or_namespace_that_ros_does_not_have_is_named(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    command: ModuleType,
    domain: str,
    namespace: str,
    line: str,
) -> None:
    """Exit code 2 and one line; no process starts."""
    monkeypatch.setenv("ROS_DOMAIN_ID", domain)
    assert command.main(["--namespace", namespace], Quiet()) == 2
    printed = capsys.readouterr()
    assert printed.err == f"{line}\n"
    assert printed.out == ""


PLANT = {"mode": "realtime", "paused": "False", "speed factor": "0.870", "lag (s)": "1.500"}
READINGS = {
    "time": 0.058,
    "position": 0.058,
    "pressure_a": 401325.0,
    "pressure_b": None,
    "supply_pressure": 621325.0,
    "voltage": 5.0,
    "reference": 0.058,
}


def status(level: str = "OK", **values: str) -> RigStatus:
    """A rig of which all but one pressure is known."""
    nodes = {
        "plant": NodeStatus(level, "running", {**PLANT, "overruns": "3", **values}),
        "controller": NodeStatus("WARN", "since start: positions lost", {}),
    }
    return RigStatus("/left", nodes, READINGS)


def test_the_screen_shows_mm_and_both_kinds_of_pressure() -> None:
    """Levels with their messages, speed factor and lag as the plant says them."""
    assert screen(status()) == [
        "rig           /left, realtime, running",
        "plant         OK: running",
        "controller    WARN: since start: positions lost",
        "plant time    0.058 s",
        "speed factor  0.870",
        "lag           1.500 s",
        "overruns      3",
        "position      58.000 mm",
        "reference     58.000 mm",
        "valve voltage 5.000 V",
        "chamber A     0.300 MPa gauge, 0.401 MPa absolute",
        "chamber B     -",
        "supply        0.520 MPa gauge, 0.621 MPa absolute",
    ]


@pytest.mark.parametrize("written", ["much", "", "nan", "inf", "9" * 5000, "0x10", "-"])
def test_what_a_foreign_node_writes_in_place_of_a_number_is_not_believed(written: str) -> None:
    """A diagnostic in the plant's name: gauge pressures and movement are as if it said nothing."""
    said = {"atmosphere (Pa)": written, "speed factor": written}
    foreign = status(**said)
    assert foreign.atmosphere == 101325.0
    assert not foreign.is_running
    assert screen(foreign)[-3] == "chamber A     0.300 MPa gauge, 0.401 MPa absolute"


def test_a_rig_that_stands_still_is_not_shown_as_running() -> None:
    """Paused by request, or for another reason."""
    assert "/left, realtime, paused" in screen(status(paused="True"))[0]
    still = {"mode": "lockstep", "speed factor": "0.000"}
    assert "/left, lockstep, standing still" in screen(status(**still))[0]


def test_a_rig_whose_time_is_over_is_shown_as_ended() -> None:
    """It stands still because its duration is over, and what to do is said."""
    ended = status(**{"speed factor": "0.000"})
    ended.nodes["plant"] = NodeStatus("WARN", "ended; since start: overruns", PLANT)
    state = "ended: time.duration is over, rodless reset begins anew"
    assert screen(ended)[0] == f"rig           /left, realtime, {state}"


def test_two_rigs_of_one_name_are_not_well() -> None:
    """However well each node is."""
    found = status()
    assert found.is_well
    assert not replace(found, problems=("2 nodes named plant",)).is_well


@pytest.mark.parametrize(
    ("level", "well"), [("OK", True), ("WARN", True), ("ERROR", False), ("missing", False)]
)
def test_warnings_are_well_and_errors_are_not(level: str, well: bool) -> None:
    """What was once wrong does not count; what is, does."""
    assert status(level).is_well is well
