# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The examples run, and draw the pictures that the site shows."""

import json
import re
import runpy
from pathlib import Path

import numpy as np
import pytest
from extent import extensive
from matplotlib.image import imread

from rodless_control import ControllerParameters, PidParameters, references
from rodless_lab import closed_loop
from rodless_sim import RigParameters

ROOT = Path(__file__).resolve().parents[1]
PAGE = (ROOT / "docs" / "examples.md").read_text(encoding="utf-8")
PICTURES = {
    "step": r"calibrated: within 0\.2 mm after 0\.[23]\d s",
    "own_law": r"my law: [+-]0\.\d+ mm from the target",
    "friction_sweep": r"40 rigs, 0\.\d\d to 0\.\d\d mm",
}


@pytest.mark.slow
@pytest.mark.parametrize("name", PICTURES)
def test_an_example_draws_its_picture(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """It prints what it found; its picture is as large as the one in the docs, and not empty."""
    file = tmp_path / "picture.png"
    monkeypatch.setattr("sys.argv", [f"{name}.py", str(file)])
    runpy.run_path(str(ROOT / "examples" / f"{name}.py"), run_name="__main__")
    assert re.search(PICTURES[name], capsys.readouterr().out)
    drawn, shown = imread(file), imread(ROOT / "docs" / f"example_{name}.png")
    assert drawn.shape == shown.shape
    assert np.ptp(drawn) > 0.9
    assert f"](example_{name}.png)" in PAGE


@extensive
@pytest.mark.ros
def test_the_fault_comes_in_the_middle_of_the_run(tmp_path: Path) -> None:
    """Over the nodes in lock-step: until the fault, the samples are those of `closed_loop`."""
    file = tmp_path / "run.csv"
    runpy.run_path(str(ROOT / "examples" / "friction_fault.py"))["main"](str(file))
    lines = [line for line in file.read_text().splitlines() if not line.startswith("#")]
    columns = lines[0].split(",")
    values = np.array([line.split(",") for line in lines[1:]], dtype=float)
    position = values[:, columns.index("position")]
    assert len(position) == 6001
    assert position[2000] == pytest.approx(0.058, abs=3e-4)
    assert position[-1] == pytest.approx(0.020, abs=2e-3)
    law = PidParameters.preset("calibrated")
    again = closed_loop(
        RigParameters.preset("calibrated"), law, references.step(0.0, 0.058, at=0.0), 2.0, 1e-3
    )
    assert np.ptp(again.position) == pytest.approx(np.ptp(position[:2001]), abs=1e-4)


def test_a_law_is_learned_and_run_by_the_node_it_is_written_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It never costs more than before; the file it writes is a law for the node, as learned."""
    monkeypatch.syspath_prepend(str(ROOT / "examples"))
    train = runpy.run_path(str(ROOT / "examples" / "train_law.py"))
    costs: list[float] = []
    weights = train["learn"](
        generations=2, rigs=2, duration=0.12, progress=lambda _, cost: costs.append(cost)
    )
    assert len(costs) == 2
    assert costs[1] <= costs[0]
    file = tmp_path / "learned.yaml"
    train["write"](file, weights)
    found = ControllerParameters.for_law("learned_law:Learned").from_file(file)
    assert found["learned.weights"] == tuple(weights.tolist())
    step = references.step(0.0, 0.058, at=0.1)
    run = closed_loop(RigParameters.preset("calibrated"), found, step, 2.0, 1e-3)
    assert abs(run.error[-1]) < 0.02


def test_every_example_is_on_the_page() -> None:
    """Each file of the folder has a line there, and each is tested here or by the site."""
    files = {path.name for path in (ROOT / "examples").iterdir() if path.is_file()}
    assert files == set(re.findall(r"\(\.\./examples/([\w.]+)\)", PAGE))
    assert {name.removesuffix(".py") for name in files if name.endswith(".py")} == {
        *PICTURES,
        "friction_fault",
        "train_law",
        "learned_law",
    }


def test_notebooks_are_kept_without_outputs() -> None:
    """What comes out is made when the site is built."""
    for path in (ROOT / "examples").glob("*.ipynb"):
        cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
        code = [cell for cell in cells if cell["cell_type"] == "code"]
        assert code
        assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in code)
