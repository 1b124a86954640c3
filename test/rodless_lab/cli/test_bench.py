# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless bench`: where its figures go, and where psutil, an extra, is not installed."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from quiet_stop import Quiet

from rodless_lab.cli import bench as verb

WITHOUT_PSUTIL = (
    "import sys; sys.modules['psutil'] = None; from rodless_lab.cli.main import main; main()"
)


def bench(*arguments: str) -> subprocess.CompletedProcess[str]:
    """Run the command in a Python without psutil."""
    return subprocess.run(
        [sys.executable, "-c", WITHOUT_PSUTIL, "bench", *arguments],
        capture_output=True,
        text=True,
        timeout=60.0,
        check=False,
    )


def test_help_needs_nothing() -> None:
    """--help explains the options and ends with 0."""
    run = bench("--help")
    assert run.returncode == 0, run.stderr
    assert "--output" in run.stdout


@pytest.mark.parametrize("arguments", [[], ["--output", "elsewhere.json"]])
def test_without_psutil_it_says_how_to_get_it(arguments: list[str]) -> None:
    """One line with the command to type, exit code 2, and nothing is measured."""
    run = bench(*arguments)
    assert run.returncode == 2
    assert run.stdout == ""
    assert run.stderr == "rodless bench needs psutil: pip install 'rodless_sim[bench]'\n"


def test_one_part_leaves_the_figures_of_a_whole_run_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A whole run fills metrics.json; one part goes to a file of its own."""
    pytest.importorskip("psutil")
    measured = {"solvers": 1.0, "nodes": 2.0}
    parts = {name: lambda *_, name=name: {name: measured[name]} for name in measured}
    monkeypatch.setattr(verb, "PARTS", parts)
    monkeypatch.chdir(tmp_path)
    assert verb.main([], Quiet()) == 0
    assert verb.main(["--only", "nodes"], Quiet()) == 0
    found = {path.name: json.loads(path.read_text()) for path in Path("results/bench").iterdir()}
    assert found == {"metrics.json": measured, "nodes.json": {"nodes": 2.0}}
