# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless experiment` as its user sees it: exit codes, the report, the terminal."""

import base64
import math
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import pytest
from no_room import fill_up
from quiet_stop import Quiet

from rodless_lab.cli.experiment import main
from rodless_lab.experiments import catalogue
from rodless_lab.experiments.experiment import Experiment, Options
from rodless_lab.experiments.result import Comparison, Limits, Picture
from rodless_lab.figures.style import label, panels


def draw() -> object:
    figure, (axes,) = panels()
    axes.plot([0.0, 1.0], [0.0, 1.0], label="line")
    label(axes, "time / s", "position / mm")
    return figure


@dataclass(frozen=True)
class Fake:
    """A result of one number."""

    value: float

    @property
    def comparisons(self) -> tuple[Comparison, ...]:
        """One judged number and one that is only shown."""
        return (
            Comparison("a <b> & c", self.value, "mm", "2", Limits(1.0, 3.0, "because")),
            Comparison("shown only", -1e-9, "", "nothing"),
        )

    pictures = (Picture("fake", "a <line>", draw),)
    remarks = ("x < y with `--code`",)


@pytest.fixture
def experiment(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Callable[[float], int]:
    """Run the command with a single experiment that gives the number asked for."""

    def run(value: float) -> int:
        fake = Experiment("fake", "Fake", "Fig. 0", "Nothing.", lambda _: Fake(value))
        monkeypatch.setitem(catalogue.EXPERIMENTS, "fake", fake)
        return main(["fake", "--output", str(tmp_path / "out")], Quiet())

    return run


@pytest.mark.parametrize("value", [1.0, 2.0, 3.0])
def test_numbers_within_their_limits_end_with_0(
    experiment: Callable[[float], int], value: float
) -> None:
    """Limits are inclusive; a run whose judged numbers all keep them succeeds."""
    assert experiment(value) == 0


@pytest.mark.parametrize("value", [0.999, 3.001, math.nan, math.inf])
def test_a_number_out_of_its_limits_ends_with_1_and_is_named(
    experiment: Callable[[float], int], value: float, capsys: pytest.CaptureFixture[str]
) -> None:
    """Too small, too large and not a number at all: exit code 1, and the terminal says which."""
    assert experiment(value) == 1
    assert "leaves its limits: a <b> & c" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--position", "250"], "--position 250: must be from 0 to 200 mm"),
        (["--amplitude", "300"], "a sine of 300 mm about 100 mm leaves the stroke of 200 mm"),
        (["--amplitude", "-5"], "a sine of -5 mm: must be 0.01 mm or more"),
        (["--amplitude", "0"], "a sine of 0 mm: must be 0.01 mm or more"),
        (["--amplitude", "1e-300"], "a sine of 1e-300 mm: must be 0.01 mm or more"),
    ],
)
def test_options_are_checked_before_anything_runs(
    options: list[str],
    said: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Whatever is asked for: exit code 2, the option in the words of its user, no folder."""
    ran: list[object] = []
    for name, one in catalogue.EXPERIMENTS.items():
        monkeypatch.setitem(catalogue.EXPERIMENTS, name, replace(one, run=ran.append))
    assert main(["all", "--output", str(tmp_path / "out"), *options], Quiet()) == 2
    printed = capsys.readouterr()
    assert said in printed.err
    assert (printed.out, printed.err.count("\n")) == ("", 1)
    assert ran == []
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("text", ["nan", "inf", "x"])
def test_a_length_that_is_none_is_refused(text: str, capsys: pytest.CaptureFixture[str]) -> None:
    """By its value and its option."""
    with pytest.raises(SystemExit, match="2"):
        main(["sine", "--centre", text], Quiet())
    assert f"argument --centre: '{text}' is not a length in mm" in capsys.readouterr().err


@pytest.mark.parametrize("text", ["-1", "1.5", "1_0", "x"])
def test_a_seed_that_is_none_is_refused(text: str, capsys: pytest.CaptureFixture[str]) -> None:
    """By its value and its option."""
    with pytest.raises(SystemExit, match="2"):
        main(["all", "--seed", text], Quiet())
    said = f"argument --seed: '{text}' is not a whole number from 0 on"
    assert said in capsys.readouterr().err


# By the field of Options: what the user writes, and what it is then.
GIVEN = {
    "presets": ("--preset", "paper", ("paper",)),
    "amplitude": ("--amplitude", "7", 7e-3),
    "centre": ("--centre", "90", 90e-3),
    "position": ("--position", "50", 50e-3),
    "seed": ("--seed", "5", 5),
}


@pytest.mark.parametrize("name", catalogue.EXPERIMENTS)
def test_an_experiment_takes_the_options_that_it_looks_at(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Those reach it; each other one is refused with the experiments that take it."""
    one, asked = catalogue.EXPERIMENTS[name], list[Options]()

    def run(options: Options) -> Fake:
        asked.append(options)
        return Fake(2.0)

    monkeypatch.setitem(catalogue.EXPERIMENTS, name, replace(one, run=run))
    for field, (option, text, value) in GIVEN.items():
        asked.clear()
        code = main([name, "--output", str(tmp_path / "out"), option, text], Quiet())
        said = capsys.readouterr().err
        if field in one.takes:
            assert (code, said) == (0, "")
            assert asked == [replace(Options(), **{field: value})]
        else:
            assert (code, asked) == (2, [])
            assert said.startswith(f"{option}: {name} does not take it; these do: ")


def test_a_folder_that_cannot_be_is_found_out_before_anything_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A file in its place: exit code 2 and the name, not minutes of work and a traceback."""
    ran: list[object] = []
    fake = Experiment("fake", "Fake", "Fig. 0", "Nothing.", ran.append)
    monkeypatch.setitem(catalogue.EXPERIMENTS, "fake", fake)
    (tmp_path / "file").write_text("mine")
    assert main(["fake", "--output", str(tmp_path / "file")], Quiet()) == 2
    assert f"{tmp_path / 'file'}: cannot be written" in capsys.readouterr().err
    assert ran == []
    assert (tmp_path / "file").read_text() == "mine"


def test_a_picture_that_cannot_be_written_is_named(
    experiment: Callable[[float], int], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A folder where a picture should go: exit code 2, not 1, which speaks of the physics."""
    (tmp_path / "out" / "fake.png").mkdir(parents=True)
    assert experiment(2.0) == 2
    assert "fake.png" in capsys.readouterr().err


def test_a_report_that_finds_no_room_leaves_the_earlier_one(
    experiment: Callable[[float], int],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Exit code 2 and the file; a picture and a table are of one run, wherever the disk is full."""
    experiment(2.0)
    out = tmp_path / "out"
    earlier = {file: file.read_bytes() for file in out.iterdir()}
    for room in range(len(earlier)):
        with monkeypatch.context() as patch:
            fill_up(patch, room)
            assert experiment(5.0) == 2
        assert "cannot be written: No space left on device" in capsys.readouterr().err
        assert {file: file.read_bytes() for file in out.iterdir()} == earlier
    assert experiment(5.0) == 1
    assert (out / "summary.md").read_bytes() != earlier[out / "summary.md"]


def test_report_carries_everything_itself(
    experiment: Callable[[float], int], tmp_path: Path
) -> None:
    """The HTML holds the picture's own bytes and needs no other file; texts are escaped."""
    experiment(5.0)
    html = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    (embedded,) = re.findall(r'src="data:image/png;base64,([^"]+)"', html)
    assert base64.b64decode(embedded) == (tmp_path / "out" / "fake.png").read_bytes()
    assert re.findall(r'(?:src|href)="(?!data:|#)', html) == []
    assert "a &lt;b&gt; &amp; c" in html
    assert "a <b>" not in html
    assert "<li>x &lt; y with <code>--code</code></li>" in html
    assert "class=leaves" in html


def test_summary_says_what_is_wrong_in_markdown(
    experiment: Callable[[float], int], tmp_path: Path
) -> None:
    """The summary has the table with its verdict, and names a picture that is there."""
    experiment(5.0)
    summary = (tmp_path / "out" / "summary.md").read_text(encoding="utf-8")
    assert "| a <b> & c | 5.00 mm | 2 | 1.00 to 3.00 | NO | because |" in summary
    assert "| shown only | 0.00 | nothing |  |  |  |" in summary
    (picture,) = re.findall(r"!\[[^]]*\]\(([^)]+)\)", summary)
    assert (tmp_path / "out" / picture).read_bytes().startswith(b"\x89PNG")


def test_a_sine_beyond_the_stroke_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A sine of 120 mm about 100 mm leaves the cylinder: exit code 2, and no report."""
    out = tmp_path / "out"
    assert main(["sine", "--amplitude", "120", "--output", str(out)], Quiet()) == 2
    assert "120 mm about 100 mm leaves the stroke" in capsys.readouterr().err
    assert not out.exists()


def test_a_name_that_does_not_exist_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    """An unknown experiment ends with exit code 2 and the names there are."""
    with pytest.raises(SystemExit) as ended:
        main(["frictoin"], Quiet())
    assert ended.value.code == 2
    assert "fixed-chamber" in capsys.readouterr().err
