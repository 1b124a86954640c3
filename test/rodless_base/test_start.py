# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Starting an executable, and asking it to stop at any moment."""

import importlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

import rodless_base
from rodless_base.start import AGAIN_SECONDS
from rodless_lab.cli import entry

pytestmark = pytest.mark.usefixtures("hears_hangup")

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
# Only a hung process meets it.
TIMEOUT = 60.0

PACKAGES = Path(rodless_base.__file__).parents[1]
SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"

# The package that all others stand on, long in coming as on a busy machine.
SLOW = f"""
import sys
print("importing", flush=True)
sys.stdin.readline()
__path__ = [{str(PACKAGES / "rodless_base")!r}]
"""

IMPORTING = """
import sys
print("importing", flush=True)
sys.stdin.readline()
"""

STUBBORN = """
import sys
print("importing", flush=True)
while True:
    try:
        sys.stdin.readline()
    except BaseException:
        pass
"""

RUNNING = """
import sys

def main(stop):
    stop.from_now_on_wait()
    print("running", stop.requested, *sys.argv[1:], flush=True)
    while not stop.requested:
        pass
    print("asked", flush=True)
    sys.stdin.readline()
    print("asked again, ending", flush=True)
    return 7
"""

COMPUTING = """
import sys

def main(stop):
    stop.end_with(1, "interrupted")
    print("computing", flush=True)
    sys.stdin.readline()
"""

IMPATIENT = """
import sys

def main(stop):
    stop.end_with(1, "interrupted")
    stop.from_now_on_wait(impatient=True)
    print("compiling", flush=True)
    sys.stdin.readline()
    print("done", flush=True)
    return 7
"""

WITHOUT_ROS = """
import sys
for package in ("rclpy", "builtin_interfaces", "rcl_interfaces", "rosgraph_msgs", "sensor_msgs",
                "std_msgs", "std_srvs", "diagnostic_msgs"):
    sys.modules[package] = None
sys.argv = ["start", {module!r}]
import runpy
runpy.run_module("rodless_base.start", run_name="__main__")
"""

Start = Callable[..., subprocess.Popen[str]]


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Start]:
    """Start modules of a given text through rodless_base.start; none outlives the test."""
    started: list[subprocess.Popen[str]] = []
    paths = [str(tmp_path), os.environ.get("PYTHONPATH", "")]

    def run(text: str, *arguments: str) -> subprocess.Popen[str]:
        (tmp_path / "probe.py").write_text(text, encoding="utf-8")
        process = subprocess.Popen(
            [sys.executable, "-m", "rodless_base.start", "probe", *arguments],
            env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, paths))},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        started.append(process)
        return process

    yield run
    for process in started:
        process.kill()
        process.communicate()


def line(process: subprocess.Popen[str]) -> str:
    """Return the next line it prints."""
    assert process.stdout is not None
    return process.stdout.readline().strip()


@pytest.mark.parametrize("number", SIGNALS)
@pytest.mark.parametrize("text", [IMPORTING, STUBBORN], ids=["importing", "deaf to exceptions"])
def test_before_it_runs_a_request_ends_it_at_once(
    start: Start, text: str, number: signal.Signals
) -> None:
    """While modules are still being loaded: exit code 0, and not a word about it."""
    process = start(text)
    assert line(process) == "importing"
    process.send_signal(number)
    # Its input stays open: nothing but the signal ends the wait for a line.
    assert process.wait(TIMEOUT) == 0
    assert process.communicate() == ("", "")


VERB = ["-c", "from rodless_lab.cli.entry import main; main()", "rig"]


@pytest.mark.parametrize("number", SIGNALS)
@pytest.mark.parametrize(
    ("executable", "ending"),
    [
        ([SCRIPTS / "plant"], (0, "")),
        ([SCRIPTS / "controller"], (0, "")),
        ([SCRIPTS / "rig"], (0, "")),
        ([SCRIPTS / "recorder"], (1, "interrupted\n")),
        (VERB, (1, "interrupted\n")),
    ],
    ids=["plant", "controller", "rig", "recorder", "verb"],
)
def test_a_signal_that_nothing_of_ours_can_handle_yet_waits(
    tmp_path: Path, executable: list[str | Path], ending: tuple[int, str], number: signal.Signals
) -> None:
    """An executable or a verb whose very first import takes long ends cleanly all the same."""
    (tmp_path / "rodless_base").mkdir()
    (tmp_path / "rodless_base" / "__init__.py").write_text(SLOW, encoding="utf-8")
    with subprocess.Popen(
        [sys.executable, *executable],
        cwd=tmp_path,  # where Python without PYTHONSAFEPATH looks first
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), str(PACKAGES)])},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        assert line(process) == "importing"
        process.send_signal(number)
        process.send_signal(number)  # as `ros2 launch` and the terminal
        _, errors = process.communicate("go on\n", TIMEOUT)
    assert (process.returncode, errors) == ending


def test_importing_the_start_of_a_verb_blocks_no_signal() -> None:
    """The processes of a pool import what started theirs, and SIGTERM is to end them."""
    importlib.reload(entry)
    assert not signal.pthread_sigmask(signal.SIG_BLOCK, ()) & set(SIGNALS)


@pytest.mark.parametrize("number", SIGNALS)
def test_what_has_nothing_to_keep_ends_at_once_with_a_word(
    start: Start, number: signal.Signals
) -> None:
    """With the exit code that the program has chosen."""
    process = start(COMPUTING)
    assert line(process) == "computing"
    process.send_signal(number)
    assert process.wait(TIMEOUT) == 1
    assert process.communicate() == ("", "interrupted\n")


@pytest.mark.parametrize("number", SIGNALS)
def test_while_it_runs_requests_only_tell_it(start: Start, number: signal.Signals) -> None:
    """The program ends itself, with its own exit code; a second request does no harm."""
    process = start(RUNNING, "--some", "argument")
    assert line(process) == "running False --some argument"
    process.send_signal(number)
    assert line(process) == "asked"
    process.send_signal(number)
    output, errors = process.communicate("go on\n", TIMEOUT)
    assert (output.strip(), errors) == ("asked again, ending", "")
    assert process.returncode == 7


def test_what_nohup_starts_goes_on_when_its_terminal_closes(start: Start) -> None:
    """A terminal that closes is a request to stop, unless whoever started it has said otherwise."""
    signal.signal(signal.SIGHUP, signal.SIG_IGN)  # which what is started inherits
    try:
        process = start(RUNNING)
        assert line(process) == "running False"
    finally:
        signal.signal(signal.SIGHUP, signal.SIG_DFL)
    process.send_signal(signal.SIGHUP)
    process.send_signal(signal.SIGTERM)
    assert line(process) == "asked"
    process.send_signal(signal.SIGHUP)
    process.communicate("go on\n", TIMEOUT)
    assert process.returncode == 7


@pytest.mark.parametrize("number", SIGNALS)
def test_what_takes_long_ends_at_once_when_asked_again(
    start: Start, number: signal.Signals
) -> None:
    """The first request is answered by a line that says so; one that comes twice is one."""
    process = start(IMPATIENT)
    assert process.stderr is not None
    assert line(process) == "compiling"
    process.send_signal(number)
    assert process.stderr.readline() == "\n"
    said = process.stderr.readline()
    assert said == "ending with what is under way; Ctrl-C once more ends it at once\n"
    process.send_signal(number)  # as `ros2 launch` and the terminal
    asked_at = time.monotonic()
    while time.monotonic() < asked_at + AGAIN_SECONDS:
        assert process.poll() is None
    process.send_signal(number)
    assert process.wait(TIMEOUT) == 1
    assert process.communicate() == ("", "interrupted\n")


@pytest.mark.parametrize("number", SIGNALS)
def test_whoever_is_patient_has_what_was_under_way(start: Start, number: signal.Signals) -> None:
    """With the program's own exit code."""
    process = start(IMPATIENT)
    assert line(process) == "compiling"
    process.send_signal(number)
    output, _ = process.communicate("compiled\n", TIMEOUT)
    assert output == "done\n"
    assert process.returncode == 7


@pytest.mark.parametrize(
    "module", ["rodless_sim.node.plant_node", "rodless_control.node.controller_node"]
)
def test_without_ros_it_says_what_to_do(module: str) -> None:
    """Where no ROS package can be imported: one clear sentence, exit code 1, no traceback."""
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_ROS.format(module=module)],
        capture_output=True,
        text=True,
        check=False,
        timeout=TIMEOUT,
    )
    assert done.returncode == 1
    assert done.stderr.startswith("rclpy is missing: source a ROS 2 distribution, or install")
    assert done.stderr.count("\n") == 1


def test_another_missing_module_is_not_blamed_on_ros(start: Start) -> None:
    """With rclpy at hand the missing module is the one that is named."""
    process = start("import rodless_no_such_module")
    _, errors = process.communicate(timeout=TIMEOUT)
    assert process.returncode == 1
    assert "No module named 'rodless_no_such_module'" in errors
    assert "rclpy is missing" not in errors


@pytest.mark.ros
@pytest.mark.parametrize(
    "module", ["rodless_sim.node.plant_node", "rodless_control.node.controller_node"]
)
def test_a_node_loads_nothing_that_only_the_lab_needs(module: str) -> None:
    """What draws, stores and analyses costs seconds of a start."""
    lab = ("matplotlib", "pandas", "mcap", "scipy.stats", "scipy.signal", "rodless_lab")
    code = f"import sys, {module}\nprint(*sorted(set(sys.modules).intersection({lab!r})), '.')"
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=False,
        timeout=TIMEOUT,
    )
    assert done.stdout.split() == ["."], done.stdout + done.stderr


LEAVING = """
import signal
import time
from rodless_base.start import Stop

class Slow:
    def __del__(self, sleep=time.sleep):
        sleep(0.3)

stop, slow = Stop(), Slow()
signal.signal(signal.SIGALRM, lambda *_: None)
signal.setitimer(signal.ITIMER_REAL, 0.05, 0.05)
"""


def test_a_timer_that_still_runs_kills_nobody_on_its_way_out() -> None:
    """Python gives the signal back its deadly default before it takes its modules down."""
    done = subprocess.run([sys.executable, "-c", LEAVING], check=False, timeout=60)
    assert done.returncode == 0
