# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The pages of docs/experiments against what the experiments produce."""

import re
from pathlib import Path

import pytest

from rodless_lab.experiments.catalogue import EXPERIMENTS
from rodless_lab.experiments.experiment import Options
from rodless_lab.reports.page import page

FOLDER = Path(__file__).resolve().parents[1] / "docs" / "experiments"
NUMBER = r"[−-]?\d+(?:\.\d+)?"


def parts(text: str) -> tuple[str, list[str]]:
    """Split a text into its words, numbers left out, and its numbers."""
    return re.sub(NUMBER, "#", text), re.findall(NUMBER, text)


def close(first: str, second: str) -> bool:
    """Whether two numbers agree to 2 % or two units of the last digit that is shown.

    Machines round differently, and stick-slip magnifies it.
    """
    values = [float(text.replace("−", "-")) for text in (first, second)]
    last_digit = 10.0 ** -len(second.partition(".")[2])
    return abs(values[0] - values[1]) <= max(0.02 * abs(values[1]), 2.0 * last_digit)


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.slow] if name == "friction" else [])
        for name in EXPERIMENTS
    ],
)
def test_page_says_what_the_experiment_gives(name: str) -> None:
    """Text, table and remarks of the page are those of a fresh run, and every number holds."""
    result = EXPERIMENTS[name].run(Options())
    assert [row.quantity for row in result.comparisons if not row.holds] == []
    written = (FOLDER / f"{name}.md").read_text(encoding="utf-8")
    words, numbers = parts(written)
    fresh_words, fresh_numbers = parts(page(EXPERIMENTS[name], result))
    assert words == fresh_words
    different = [pair for pair in zip(fresh_numbers, numbers, strict=True) if not close(*pair)]
    assert different == []


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_page_shows_its_command_and_pictures(name: str) -> None:
    """The page has the command that makes it, and at least one picture, a PNG beside it."""
    written = (FOLDER / f"{name}.md").read_text(encoding="utf-8")
    assert f"rodless experiment {name}\n" in written
    pictures = re.findall(r"!\[[^]]+\]\(([^)]+)\)", written)
    assert pictures
    for picture in pictures:
        assert (FOLDER / picture).read_bytes().startswith(b"\x89PNG\r\n")


def test_no_page_or_picture_is_left_over() -> None:
    """Every file of the folder belongs to an experiment there is, or is shown by its page."""
    pages = {f"{name}.md" for name in EXPERIMENTS}
    texts = [(FOLDER / one).read_text(encoding="utf-8") for one in pages]
    shown = {picture for text in texts for picture in re.findall(r"\]\(([^)/]+\.png)\)", text)}
    assert {path.name for path in FOLDER.iterdir()} == pages | shown
