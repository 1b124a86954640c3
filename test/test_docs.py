"""The docs against the code: tables, links, snippets, and the tests that the errata name."""

import ast
import re
from pathlib import Path

import pytest

from rodless_control import ControllerParameters
from rodless_lab.reports.parameters import parameter_reference
from rodless_lab.runs.measured_run import run_of_trace
from rodless_sim import RigParameters, simulate

ROOT = Path(__file__).resolve().parents[1]
PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")])


def test_parameter_page_is_what_the_declarations_say() -> None:
    """docs/parameters.md is the page that `rodless docs` writes from the declarations."""
    page = (ROOT / "docs" / "parameters.md").read_text(encoding="utf-8")
    assert page == parameter_reference()


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.name)
def test_relative_links_lead_somewhere(page: Path) -> None:
    """Every link and picture of a page that is not on the web exists in the tree."""
    targets = re.findall(r"\]\(([^)#]+)", page.read_text(encoding="utf-8"))
    local = [target for target in targets if "://" not in target]
    assert [target for target in local if not (page.parent / target).exists()] == []


def errata_rows() -> list[list[str]]:
    """Cells of the errata table's rows."""
    lines = (ROOT / "docs" / "errata.md").read_text(encoding="utf-8").splitlines()
    rows = [line.strip("| ").split(" | ") for line in lines if line.startswith("| ")]
    return rows[1:]


@pytest.mark.parametrize("row", errata_rows(), ids=lambda row: row[0])
def test_every_erratum_names_tests_that_exist(row: list[str]) -> None:
    """Each row of the errata page names at least one test, and the suite has it."""
    named = re.findall(r"`(test_\w+\.py)::(test_\w+)`", row[-1])
    assert named
    for file, function in named:
        (path,) = (ROOT / "test").rglob(file)
        tree = ast.parse(path.read_text(encoding="utf-8"))
        assert function in {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}


def test_readme_snippet_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The Python of the README runs as it stands, where there is a bag named run1."""
    from rig_bag import write  # noqa: PLC0415  needs ROS, which the other pages do without

    write(tmp_path / "run1", run_of_trace(simulate(RigParameters(), [5.6] * 100, 1e-3), 6e5))
    monkeypatch.chdir(tmp_path)
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    snippets = re.findall(r"```python\n(.*?)```", readme, re.DOTALL)
    assert snippets
    for snippet in snippets:
        exec(compile(snippet, "README.md", "exec"), {})
    saved = {"step.csv", "run1.csv", "joint_states.parquet"}
    assert {file.name for file in tmp_path.iterdir() if file.is_file()} == saved


def test_readme_names_parameters_that_exist_with_their_defaults() -> None:
    """Each parameter the README shows exists, and the numbers beside it are its default."""
    declarations = {**RigParameters.DECLARATIONS, **ControllerParameters.DECLARATIONS}
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    named = set(
        re.findall(r"`((?:supply|valve|cylinder|controller|reference|time)\.[a-z_.]+)[`:]", readme)
    )
    assert named
    assert named <= declarations.keys() | {"valve.py", "cylinder.py"}
    for name in ("supply.pressure", "cylinder.moving_mass", "controller.kp"):
        row = next(line for line in readme.splitlines() if line.startswith(f"| `{name}`"))
        assert float(re.findall(r"\| ([\d.]+)", row)[0]) == declarations[name].default
