# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The page that brings data of another logger in, followed to the letter."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import pytest

from rodless_lab import MeasuredRun
from rodless_sim import RigParameters, Trace, simulate

PAGE = Path(__file__).resolve().parents[1] / "docs" / "identification.md"
VOLTAGES = np.repeat([5.4, 5.5, 5.6, 5.7], 1500)
ATMOSPHERE = 101325.0
SUPPLY = RigParameters().number("supply.pressure")


@pytest.fixture(scope="module")
def true() -> Trace:
    """A carriage that moves uniformly at four speeds."""
    return simulate(RigParameters(), VOLTAGES, 1e-3, position=0.01)


def write_as_a_logger_would(path: Path, true: Trace) -> None:
    """Write ``true`` in mm and bar gauge, each sample up to 0.1 ms off its time."""
    jitter = np.random.default_rng(1).uniform(-1e-4, 1e-4, len(true.time))
    jitter[[0, -1]] = 0.0
    stamps = true.time + jitter

    def at_the_stamps(values: Any) -> Any:
        return np.interp(stamps, true.time, values)

    columns = {
        "time_s": stamps,
        "position_mm": at_the_stamps(true.position) * 1e3,
        "a_bar": (at_the_stamps(true.pressure_a) - ATMOSPHERE) * 1e-5,
        "b_bar": (at_the_stamps(true.pressure_b) - ATMOSPHERE) * 1e-5,
        "supply_bar": np.full(len(stamps), (SUPPLY - ATMOSPHERE) * 1e-5),
        "voltage_V": true.voltage,
    }
    pandas.DataFrame(columns).to_csv(path, index=False)


def test_data_of_another_logger_come_in_as_the_page_says(
    true: Trace, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its code, on a table in mm and bar gauge: the run is the one simulated, and so is B."""
    section = PAGE.read_text(encoding="utf-8").partition("## From arrays or a CSV file")[2]
    (code,) = re.findall(r"```python\n(.*?)```", section, re.DOTALL)
    write_as_a_logger_would(tmp_path / "bench.csv", true)
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    exec(compile(code, PAGE.name, "exec"), names)
    run = names["run"]
    count = len(run.time)
    assert abs(count - len(true.time)) <= 1
    assert run.position == pytest.approx(true.position[:count], abs=2e-6)
    assert run.pressure_a == pytest.approx(true.pressure_a[:count], abs=200.0)
    assert run.supply_pressure == pytest.approx(np.full(count, SUPPLY))
    # A change of the command is seen at most one sample late.
    changes = np.flatnonzero(np.diff(run.voltage))
    assert changes == pytest.approx([1499, 2999, 4499], abs=1)
    assert run.commanded
    assert names["fit"].forward.viscous.covers(RigParameters().number("friction.forward.viscous"))
    assert names["rig"]["friction.forward.viscous"] == names["found"].value


def test_a_saved_run_comes_back_from_its_csv(true: Trace, tmp_path: Path) -> None:
    """By the names of its columns, to the last bit, as the page says."""
    supply = np.full(len(true.time), SUPPLY)
    run = MeasuredRun(
        true.time, true.position, true.pressure_a, true.pressure_b, supply, true.voltage
    )
    run.save(tmp_path / "run.csv")
    table = pandas.read_csv(tmp_path / "run.csv", comment="#")
    again = MeasuredRun(**{name: table[name].to_numpy() for name in table})
    for name, values in run.columns().items():
        assert np.array_equal(getattr(again, name), values), name
