# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The picture of Sobol indices and its CSV: whose they are, all points, and their intervals."""

import io

import numpy as np
import pandas
import pyarrow as arrow
import pytest

from rodless_lab.figures.table import table_of
from rodless_lab.simulation.run_metrics import RunMetrics
from rodless_lab.studies.pictures import draw_sensitivities
from rodless_lab.studies.results import Results
from rodless_lab.studies.sensitivity import Indices, saltelli
from rodless_lab.studies.summary import sensitivities, sensitivity_table

AXES = ("supply.pressure", "cylinder.moving_mass", "controller.law")
FEW_ROWS = Indices(
    first=np.array([-0.6, 0.2, 1.3]),
    first_interval=np.array([0.5, 0.1, 40.0]),
    total=np.array([0.1, 0.3, 1.8]),
    total_interval=np.array([0.2, 0.1, 0.6]),
)


def test_the_csv_tells_both_indices_apart_and_has_their_intervals() -> None:
    """Each has its name from the legend, and the ends of its intervals, as far as they reach."""
    table = table_of(draw_sensitivities(AXES, {"air": FEW_ROWS}))
    found = {
        name: rows["y"].tolist()
        for name, rows in pandas.read_csv(io.StringIO(table), comment="#").groupby("line")
    }
    assert found == {
        "by itself": [-0.6, 0.2, 1.3],
        "by itself, from": pytest.approx([-1.1, 0.1, -38.7]),
        "by itself, to": pytest.approx([-0.1, 0.3, 41.3]),
        "in all": [0.1, 0.3, 1.8],
        "in all, from": pytest.approx([-0.1, 0.2, 1.2]),
        "in all, to": pytest.approx([0.3, 0.4, 2.4]),
    }
    expected = "x: 0 = supply.pressure, 1 = cylinder.moving_mass, 2 = controller.law; y: air;"
    assert expected in table.splitlines()[0]


def test_no_index_lies_outside_of_its_panel() -> None:
    """Of few rows they may be below 0 and above 1; one wild interval leaves the rest readable."""
    low, high = draw_sensitivities(AXES, {"air": FEW_ROWS}).axes[0].get_ylim()
    assert -3.0 < low < -1.1
    assert 2.4 < high < 5.0
    within = Indices(*(np.full(3, value) for value in (0.3, 0.05, 0.4, 0.05)))
    assert draw_sensitivities(AXES, {"air": within}).axes[0].get_ylim() == pytest.approx(
        (-0.1, 1.1)
    )


@pytest.mark.filterwarnings("error")
def test_an_index_that_is_no_number_leaves_the_others_in_sight() -> None:
    """Its panel is that of the numbers, and the table has nan in its place."""
    holed = FEW_ROWS._replace(
        first=np.array([np.nan, 0.2, 1.3]), first_interval=np.array([np.nan, np.inf, 0.1])
    )
    figure = draw_sensitivities(AXES, {"air": holed})
    figure.draw_without_rendering()
    assert figure.axes[0].get_ylim() == pytest.approx((-0.2, 2.5))
    found = pandas.read_csv(io.StringIO(table_of(figure)), comment="#").groupby("line")["y"]
    np.testing.assert_allclose(found.get_group("by itself, to"), [np.nan, np.nan, 1.4])


def test_table_and_picture_say_that_indices_are_of_the_size_of_an_error() -> None:
    """An error of either sign in turn, its size the first axis: that one makes all of the index."""
    shares = saltelli(2, 64, 1)
    count = len(shares)
    columns = {name: np.full(count, np.nan) for name in RunMetrics._fields}
    signs = np.where(np.arange(count) % 2, 1.0, -1.0)
    columns |= {"mean_error": signs * (1.0 + shares[:, 0]), "air": 1.0 + shares[:, 1]}
    columns |= {"row": np.arange(count), "failure": np.full(count, ""), "seed": np.arange(count)}
    results = Results(arrow.table(columns), ("one", "other"), count)
    found = sensitivities(results, 1)
    assert found["mean_error"].total == pytest.approx([1.0, 0.0], abs=0.05)
    lines = [
        line.split("|")[1].strip() for line in sensitivity_table(results, found).splitlines()[2:4]
    ]
    assert lines == ["mean error, size", "air"]
    labels = [panel.get_ylabel() for panel in draw_sensitivities(("one", "other"), found).axes]
    assert labels == ["mean\nerror, size", "air"]
