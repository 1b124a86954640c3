# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Which value a quantile is, in words: below each table that has one."""

import math
from pathlib import Path

import numpy as np
import pyarrow as arrow
import pytest

from rodless_lab.benchmark.laws.contest import Score
from rodless_lab.benchmark.laws.entries import of_package
from rodless_lab.benchmark.laws.tables import markdown
from rodless_lab.benchmark.laws.tasks import tasks
from rodless_lab.simulation.ensemble import Ensemble
from rodless_lab.simulation.quantile import nth, quantile
from rodless_lab.simulation.run_metrics import NO_METRICS, RunMetrics
from rodless_lab.studies.results import Results
from rodless_lab.studies.summary import summary

DOCS = Path(__file__).parents[3] / "docs"


@pytest.mark.parametrize("share", [0.01, 0.5, 0.9, 1.0])
def test_the_place_is_that_of_the_quantile(share: float) -> None:
    """Of the numbers from 1 on the quantile is its own place."""
    for count in range(1, 130):
        place = nth(count, share)
        assert place.rstrip("stndrh") == f"{quantile(np.arange(count) + 1.0, share):g}"


@pytest.mark.parametrize(
    ("count", "said"),
    [
        *((1, "1st"), (2, "2nd"), (3, "3rd"), (4, "4th"), (11, "11th"), (12, "12th"), (13, "13th")),
        *((21, "21st"), (102, "102nd"), (111, "111th"), (1013, "1013th"), (1023, "1023rd")),
    ],
)
def test_places_end_as_in_english(count: int, said: str) -> None:
    """The last of so many; eleven to thirteen are exceptions in every hundred."""
    assert nth(count, 1.0) == said


def page(count: int) -> str:
    """Return the summary of so many rows, which overshoot by 1 mm, 2 mm and so on."""
    runs = [NO_METRICS._replace(overshoot=1e-3 * (place + 1)) for place in range(count)]
    columns = {"row": np.arange(count), "failure": [""] * count, "seed": np.arange(count)}
    columns |= dict(zip(RunMetrics._fields, np.array(runs).T, strict=True))
    return summary(Results(arrow.table(columns), (), count))


def test_a_sweep_says_which_values_its_table_has() -> None:
    """Of eight rows the fourth and the eighth, whose overshoots stand there; one row is itself."""
    text = page(8)
    assert "| overshoot, mm | 4.000 | 8.000 | 8.000 | 0 |" in text
    assert "8 rows.\nBy size, the median is the 4th value, 90 % the 8th; rows with none" in text
    assert "By size" not in page(1)


@pytest.mark.parametrize(
    ("count", "said"),
    [
        (10, "Median / 90 % / worst of 10 rigs: by size the 5th, 9th and last value; a rig"),
        (1, "One rig: median, 90 % and worst are its own."),
    ],
)
def test_the_contest_says_which_values_its_tables_have(count: int, said: str) -> None:
    """The fifth and the ninth of ten; none settled but those."""
    runs = [NO_METRICS._replace(settling_time=0.1 * (place + 1)) for place in range(count - 1)]
    runs.append(NO_METRICS._replace(settling_time=math.nan))
    task = next(one for one in tasks(1) if not one.cycles)
    text = markdown([Score(of_package()[0], task, Ensemble(runs, {}))])
    assert text.startswith(said)
    if count == 10:
        assert "| 0.50 / 0.90 / – |" in text
    assert markdown([]) == "\n"


def test_the_pages_say_it_too() -> None:
    """Their example: of 100 the 50th and the 90th, of 32 the 29th."""
    assert (nth(100, 0.5), nth(100, 0.9), nth(32, 0.9), nth(32, 0.5)) == (
        "50th",
        "90th",
        "29th",
        "16th",
    )
    for name, said in (
        ("sweeps.md", "the 50th and the 90th of 100"),
        ("tuning.md", "at 0.9 the 29th of 32, at 0.5 the 16th"),
        ("laws.md", "of 100 rigs by size the 50th, the 90th and the last"),
    ):
        assert said in (DOCS / name).read_text(encoding="utf-8")
