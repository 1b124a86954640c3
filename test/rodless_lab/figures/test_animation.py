# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A run as a moving picture: what each frame shows, and what the command refuses."""

import gc
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest

from rodless_lab.cli import animate
from rodless_lab.figures.animation import (
    FRAMES_PER_SECOND,
    LAST_FRAME,
    Film,
    MovingPicture,
    frame_times,
    write_animation,
)
from rodless_lab.figures.style import STYLE
from rodless_lab.runs.measured_run import MeasuredRun, Setpoint

TIME = np.arange(101) * 1e-2
STILL = np.full(101, 3e5)
RUN = MeasuredRun(TIME, 0.1 * TIME, 2.0 * STILL, STILL, 2.0 * STILL, 5.08 + 4.0 * TIME)
STEP = Setpoint(np.array([0.5]), np.array([0.1]))


@pytest.fixture
def picture() -> MovingPicture:
    """A carriage on its way from 0 to 100 mm in 1 s, of which 0.2 to 1 s is shown."""
    with mpl.rc_context(STYLE):
        return MovingPicture(RUN, STEP, 0.2, Film(0.2, 1.0))


@pytest.mark.parametrize("time", [0.2, 0.5, 1.0])
def test_a_frame_shows_the_rig_of_its_instant(picture: MovingPicture, time: float) -> None:
    """Piston at 100 mm/s · t, the chambers from the caps to its faces, the set-point from 0.5 s."""
    picture.draw(time)
    rig, x = picture.rig, 100.0 * time
    middle = rig.piston.get_x() + 0.5 * rig.piston.get_width()
    assert middle == pytest.approx(x)
    assert rig.carriage.get_x() + 0.5 * rig.carriage.get_width() == pytest.approx(x)
    a, b = rig.chambers
    assert a.get_x() + a.get_width() == pytest.approx(rig.piston.get_x())
    assert b.get_x() == pytest.approx(rig.piston.get_x() + rig.piston.get_width())
    assert b.get_x() + b.get_width() - a.get_x() == pytest.approx(200.0 + rig.piston.get_width())
    assert rig.setpoint.get_xdata()[0] == (100.0 if time >= 0.5 else 0.0)
    assert rig.voltage.get_text().split() == [f"{5.08 + 4.0 * time:.2f}", "V"]
    # The supply's pressure and half of it look different, and no pressure is invisible.
    assert a.get_facecolor() != b.get_facecolor()
    assert a.get_facecolor()[3] == 1.0


def test_curves_grow_with_time(picture: MovingPicture) -> None:
    """Each line has the samples from the start of the film to its instant, and no later one."""
    picture.draw(0.6)
    seen = (TIME >= 0.2) & (TIME <= 0.6 + 1e-9)
    expected = [
        np.where(TIME < 0.5, 0.0, 100.0),
        100.0 * TIME,
        np.full(101, 0.6),
        np.full(101, 0.3),
        RUN.voltage,
    ]
    for (line, _), values in zip(picture.curves, expected, strict=True):
        np.testing.assert_allclose(line.get_xdata(), TIME[seen])
        np.testing.assert_allclose(line.get_ydata(), values[seen])


def test_frames_are_as_far_apart_as_the_speed_says() -> None:
    """0.8 s at a fifth of its speed are 4 s of film: 81 frames at 20 per second, both ends in."""
    times = frame_times(Film(0.2, 1.0, 0.2))
    assert len(times) == 81
    np.testing.assert_allclose(times[[0, 1, -1]], [0.2, 0.21, 1.0])


def test_the_file_is_a_gif_that_moves(tmp_path: Path) -> None:
    """It has a picture for each frame, and the last one is held: blocks that begin with a delay."""
    path = tmp_path / "run.gif"
    frames = write_animation(path, RUN, None, 0.2, Film(0.2, 0.4))
    content = path.read_bytes()
    assert content.startswith(b"GIF89a")
    held = round(LAST_FRAME * FRAMES_PER_SECOND)  # the writer may merge equal frames
    assert frames == 5
    assert frames <= content.count(b"\x21\xf9\x04") <= frames + held
    assert [file.name for file in tmp_path.iterdir()] == ["run.gif"]


def test_a_film_keeps_no_frame_but_in_256_colours(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a minute all frames in full colours were 1.4 GB; their number does not grow."""
    kept: list[int] = []

    def draw(_picture: MovingPicture, _time: float) -> None:
        images: list[Any] = [one for one in gc.get_objects() if type(one).__name__ == "Image"]
        kept.append(sum(one.mode in ("RGB", "RGBA") for one in images))

    monkeypatch.setattr(MovingPicture, "draw", draw)
    write_animation(tmp_path / "run.gif", RUN, None, 0.2, Film(0.2, 0.35))
    assert len(kept) == 4
    assert kept[3] == kept[2] == kept[1]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["calibrated", "-o", "run.mp4"], "run.mp4: only GIF is written; end the name in .gif"),
        (["no-bag", "-o", "run.gif"], "no-bag: "),
        (
            ["calibrated", "-o", "run.gif", "--namespace", "rig1"],
            "--namespace rig1: refused, a preset has no topics",
        ),
        (
            ["calibrated", "-o", "run.gif", "--end", "9"],
            "calibrated: 0 to 9 s refused, the run has 0 to 5 s",
        ),
        (
            ["calibrated", "-o", "run.gif", "--speed", "0.01"],
            "--speed 0.01 refused, 5 s must take at most 60 s; give a higher --speed, or --start "
            "and --end",
        ),
        (["calibrated", "-o", "no/folder/run.gif", "--end", "0.1"], "no/folder/run.gif: cannot be"),
    ],
    ids=["suffix", "no bag", "namespace", "end", "speed", "folder"],
)
def test_what_cannot_be_drawn_is_said_in_one_line(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    arguments: list[str],
    says: str,
) -> None:
    """Exit code 2, and no file."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "no").write_text("a file where a folder would have to be")
    assert animate.main(arguments, None) == 2
    error = capsys.readouterr().err
    assert error.startswith(says)
    assert error.count("\n") == 1
    assert [file.name for file in tmp_path.iterdir()] == ["no"]


@pytest.mark.parametrize("option", ["--start", "--end", "--speed"])
def test_what_is_no_number_is_named_as_it_was_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], option: str
) -> None:
    """With its option, in one line and exit code 2; it was "nan refused"."""
    with pytest.raises(SystemExit) as ended:
        animate.main(["calibrated", "-o", str(tmp_path / "run.gif"), option, "abc"], None)
    assert ended.value.code == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert f"argument {option}: 'abc' is not a number; see" in line
    assert not list(tmp_path.iterdir())


def test_a_preset_is_drawn(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Its step to 58 mm, from the start to where asked."""
    file = tmp_path / "step.gif"
    assert animate.main(["calibrated", "-o", str(file), "--end", "0.1"], None) == 0
    assert capsys.readouterr().out == f"{file}: 3 frames, {file.stat().st_size / 1e3:.0f} kB\n"
