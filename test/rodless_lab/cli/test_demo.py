"""The demo as a user runs it: a process of its own, real nodes, a real bag."""

import json
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

COMMAND = [sys.executable, "-c", "from rodless_lab.cli.main import main; main()", "demo"]

# A bound against hanging for ever, far above the 15 s the demo takes.
TIMEOUT = 240.0


@pytest.fixture(scope="module", params=["paper", "calibrated"])
def finished(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Output folder of a demo that ran to its end with exit code 0."""
    folder = tmp_path_factory.mktemp("demo")
    run = subprocess.run(
        [*COMMAND, "--preset", request.param, "--output", str(folder)],
        capture_output=True,
        text=True,
        timeout=TIMEOUT,
        check=False,
    )
    assert run.returncode == 0, run.stdout + run.stderr
    assert "Traceback" not in run.stderr
    return folder


def positions(bag: Path) -> Iterator[tuple[float, float]]:
    """Stamp (s) and position (m) of each sample, read by a reader that is not ours."""
    store = get_typestore(Stores.ROS2_JAZZY)
    with AnyReader([bag], default_typestore=store) as reader:
        (connection,) = (c for c in reader.connections if c.topic == "/joint_states")
        for _, _, data in reader.messages([connection]):
            message = reader.deserialize(data, connection.msgtype)
            stamp = message.header.stamp
            yield stamp.sec + stamp.nanosec * 1e-9, float(message.position[0])


def test_carriage_arrives_and_the_figures_are_those_of_the_bag(finished: Path) -> None:
    """The carriage ends within 0.2 mm of 58 mm, and metrics.json says what the bag says."""
    time, position = np.array(list(positions(finished / "bag"))).T
    metrics = json.loads((finished / "metrics.json").read_text(encoding="utf-8"))
    assert abs(position[-1] - 0.058) <= 2e-4
    assert metrics["final_error"] == pytest.approx(position[-1] - 0.058)
    assert metrics["overshoot"] == pytest.approx(max(position.max() - 0.058, 0.0))
    rise = time[position >= 0.9 * 0.058][0] - time[position >= 0.1 * 0.058][0]
    assert metrics["rise_time"] == pytest.approx(rise, abs=1.5e-3)


def test_bag_misses_no_sample(finished: Path) -> None:
    """From the first recorded sample to the last the stamps step by exactly one period."""
    time, _ = np.array(list(positions(finished / "bag"))).T
    assert len(time) > 5000
    assert np.diff(np.rint(time * 1e9)) == pytest.approx(1e6, abs=1.0)


def test_picture_is_a_picture(finished: Path) -> None:
    """A PNG of a useful size is written."""
    assert (finished / "step.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    assert (finished / "step.png").stat().st_size > 10_000


def test_interrupted_demo_ends_clean_with_a_bag_that_opens(tmp_path: Path) -> None:
    """Ctrl-C in mid-move: exit code 0 within 2 s, no traceback, and the bag can be read."""
    with subprocess.Popen(
        [*COMMAND, "--output", str(tmp_path)],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    ) as process:
        assert process.stdout is not None
        for line in process.stdout:
            if re.match("moving", line):
                break
        process.send_signal(signal.SIGINT)
        rest, _ = process.communicate(timeout=2.0)
    assert process.returncode == 0, rest
    assert "Traceback" not in rest
    assert len(list(positions(tmp_path / "bag"))) > 100
