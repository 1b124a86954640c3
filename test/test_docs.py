# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The docs against the code: tables, links, snippets, and the tests that the errata name."""

import ast
import re
from pathlib import Path

import pytest

from rodless_base.parameter_file import read_parameter_file
from rodless_control import ControllerParameters
from rodless_control.laws import LAWS
from rodless_lab.reports.options import OPTIONS, Option
from rodless_lab.reports.parameters import parameter_reference
from rodless_lab.runs.measured_run import run_of_trace
from rodless_sim import RigParameters, simulate
from rodless_sim.faults import PARAMETERS as FAULTS

ROOT = Path(__file__).resolve().parents[1]
PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")])


def test_parameter_page_is_what_the_declarations_say() -> None:
    """docs/parameters.md is the page that `rodless docs` writes from the declarations."""
    page = (ROOT / "docs" / "parameters.md").read_text(encoding="utf-8")
    assert page == parameter_reference()


def test_the_sections_of_the_parameter_page_mean_what_it_says(tmp_path: Path) -> None:
    """As a file: each is for a plant, and of those that apply the last wins."""
    (text,) = re.findall(r"```yaml\n(.*?)```", parameter_reference(), re.DOTALL)
    path = tmp_path / "page.yaml"
    path.write_text(text, encoding="utf-8")
    found = [read_parameter_file(path, "plant", namespace=f"/{name}") for name in ("left", "right")]
    assert found == [{"supply.pressure": 5e5}, {"supply.pressure": 6e5}]


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.name)
def test_relative_links_lead_somewhere(page: Path) -> None:
    """Every link and picture of a page that is not on the web exists in the tree."""
    targets = re.findall(r"\]\(([^)#]+)", page.read_text(encoding="utf-8"))
    local = [target for target in targets if "://" not in target]
    assert [target for target in local if not (page.parent / target).exists()] == []


def test_every_law_stands_on_its_page_with_a_link_to_its_file() -> None:
    """docs/laws.md lists what controller.law may name."""
    page = (ROOT / "docs" / "laws.md").read_text(encoding="utf-8")
    for name in LAWS:
        assert f"| [`{name}`](../rodless_control/laws/{name}.py) |" in page


@pytest.mark.parametrize("option", OPTIONS, ids=lambda option: option.page)
def test_every_option_has_a_page_of_one_screen(option: Option) -> None:
    """With its picture, what the picture switches on, and each default as it is declared."""
    page = (ROOT / "docs" / "options" / f"{option.page}.md").read_text(encoding="utf-8")
    assert f"]({option.page}.png)" in page
    assert len(page.splitlines()) <= 45
    assert all(name in page for name in option.values)
    declared = RigParameters.DECLARATIONS
    for cell, default in re.findall(r"^\| (`.*?) \| (\S+)", page, re.MULTILINE):
        for name in re.findall(r"`([a-z_.]+)`", cell):
            value = declared[name].default
            shown = default.strip("`")
            assert (shown if isinstance(value, str) else float(shown)) == value, name


def test_each_page_of_an_option_is_drawn() -> None:
    """No page is left without the picture that `rodless docs` draws; that of heat has two parts."""
    drawn = {option.page for option in OPTIONS} | {"heat"}
    assert {page.stem for page in (ROOT / "docs" / "options").glob("*.md")} == drawn


def rows(page: str) -> list[list[str]]:
    """Cells of the rows of all tables of a page, without the heads."""
    lines = (ROOT / "docs" / page).read_text(encoding="utf-8").splitlines()
    heads = {k - 1 for k, line in enumerate(lines) if line.startswith("|---")}
    bodies = [line for k, line in enumerate(lines) if line.startswith("| ") and k not in heads]
    return [line.strip("| ").split(" | ") for line in bodies]


def functions_are_there(named: list[tuple[str, str]]) -> None:
    """Check that the suite has each test, given by file and name."""
    assert named
    for file, function in named:
        (path,) = (ROOT / "test").rglob(file)
        tree = ast.parse(path.read_text(encoding="utf-8"))
        assert function in {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}


@pytest.mark.parametrize("row", rows("reliability.md"), ids=lambda row: row[0])
def test_every_promise_names_tests_that_exist(row: list[str]) -> None:
    """Each row of the reliability page names at least one test, and the suite has it."""
    functions_are_there(re.findall(r"`(test_\w+\.py)::(test_\w+)`", row[-1]))


@pytest.mark.parametrize("row", rows("errata.md"), ids=lambda row: row[0])
def test_every_erratum_names_tests_that_exist(row: list[str]) -> None:
    """Each row of the errata page names at least one test, and the suite has it."""
    functions_are_there(re.findall(r"`(test_\w+\.py)::(test_\w+)`", row[-1]))


def test_the_page_of_faults_has_them_all_and_its_python_runs() -> None:
    """Each parameter of a fault is on docs/faults.md, and what it shows in Python works."""
    page = (ROOT / "docs" / "faults.md").read_text(encoding="utf-8")
    assert [name for name in FAULTS if f"`{name}`" not in page] == []
    snippets = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    assert len(snippets) == 2
    for snippet in snippets:
        exec(compile(snippet, "faults.md", "exec"), {})


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with a bag named run1."""
    from rig_bag import write  # noqa: PLC0415  needs ROS, which the other pages do without

    write(tmp_path / "run1", run_of_trace(simulate(RigParameters(), [5.6] * 100, 1e-3), 6e5))
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("page", "saved"),
    [
        ("python.md", {"step.csv", "run1.csv", "joint_states.parquet"}),
        ("first-hour.md", {"run1.csv"}),
        ("bags-to-pandas.md", {"run1.csv", "run1.parquet"}),
        ("other-cylinder.md", {"my_rig.yaml"}),
    ],
)
def test_the_python_of_a_page_runs(folder: Path, page: str, saved: set[str]) -> None:
    """As it stands, block after block, with the files that the page shows."""
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    for name, content in re.findall(r"^`([\w.]+)`:\n\n```yaml\n(.*?)```", text, re.M | re.S):
        (folder / name).write_text(content, encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    assert blocks
    names: dict[str, object] = {}
    for block in blocks:
        exec(compile(block, page, "exec"), names)
    assert {file.name for file in folder.iterdir() if file.is_file()} == saved


DECLARATIONS = {**RigParameters.DECLARATIONS, **ControllerParameters.DECLARATIONS}


def test_the_page_on_choosing_names_parameters_with_their_defaults() -> None:
    """Each parameter that it shows exists, and the number beside it is its default."""
    page = (ROOT / "docs" / "choosing-parameters.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`((?:supply|valve|cylinder|controller|reference)\.[a-z_.]+)`", page))
    assert named
    assert named <= DECLARATIONS.keys()
    for name in ("supply.pressure", "cylinder.moving_mass", "controller.kp"):
        row = next(line for line in page.splitlines() if line.startswith(f"| `{name}`"))
        assert float(re.findall(r"\| ([\d.]+)", row)[0]) == DECLARATIONS[name].default


def test_each_function_that_the_model_names_exists() -> None:
    """A link `file.py#name` leads to what that file defines; the sheet has one per equation."""
    text = (ROOT / "docs" / "model.md").read_text(encoding="utf-8")
    links = re.findall(r"\[`([\w.]+)`\]\(\.\./([\w/]+\.py)#(\w+)\)", text)
    assert len(links) > 25
    for shown, file, name in links:
        tree = ast.parse((ROOT / file).read_text(encoding="utf-8"))
        kinds = (ast.FunctionDef, ast.ClassDef)
        assert name in {node.name for node in tree.body if isinstance(node, kinds)}, file
        assert shown.partition(".")[0] == name
    paper = set(map(int, re.findall(r"\((\d+)\)", text)))
    paper |= {n for a, b in re.findall(r"\((\d+)\)-\((\d+)\)", text) for n in range(int(a), int(b))}
    assert paper >= set(range(1, 32))  # every equation of the paper has its place


def test_the_model_shows_the_parameters_in_use() -> None:
    """Each parameter in a table of symbols exists, and the value is its default."""
    cells = [row for row in rows("model.md") if len(row) == 4 and row[2].startswith("`")]
    parameters = {row[2].strip("`"): row[3].split()[0] for row in cells}
    parameters = {name: value for name, value in parameters.items() if name in DECLARATIONS}
    assert len(parameters) > 25
    for name, value in parameters.items():
        default = DECLARATIONS[name].default
        if not isinstance(default, tuple):
            assert float(value) == default, name
