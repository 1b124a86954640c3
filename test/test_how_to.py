# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The how-to pages, followed to the letter on a copy of the package."""

import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest
import yaml
from extent import extensive

import rodless_base

ROOT = Path(__file__).resolve().parents[1]
PAGES = sorted((ROOT / "docs" / "how-to").glob("*.md"))
PACKAGES = ("rodless_base", "rodless_sim", "rodless_control", "rodless_lab")

pytestmark = pytest.mark.slow


@dataclass(frozen=True)
class Block:
    """A block of code: its language, its text, and the file named just above it, if any."""

    page: Path
    language: str
    text: str
    file: str


def blocks(page: Path) -> list[Block]:
    """Return the code blocks of a page in order."""
    pattern = r"(?:^`([\w./]+)`[^\n]*\n\n)?```(\w+)\n(.*?)```"
    found = re.findall(pattern, page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
    return [Block(page, language, text, file) for file, language, text in found]


def apply(change: str, text: str) -> str:
    """Return ``text`` with the lines of a diff put in place of those it shows."""
    lines = change.splitlines()
    before = "\n".join(line[1:] for line in lines if line[0] in " -")
    after = "\n".join(line[1:] for line in lines if line[0] in " +")
    assert text.count(before) == 1, f"found {text.count(before)} times:\n{before}"
    return text.replace(before, after)


@pytest.fixture(scope="module")
def extended(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the package with the files and the lines of all pages."""
    folder = tmp_path_factory.mktemp("extended")
    installed = Path(rodless_base.__file__).parents[1]
    for package in PACKAGES:
        shutil.copytree(installed / package, folder / package)
    if (installed / "config").is_dir():
        shutil.copytree(installed / "config", folder / "config")
    for page in PAGES:
        for block in blocks(page):
            if block.file and block.language in ("python", "yaml"):
                (folder / block.file).write_text(block.text, encoding="utf-8")
            elif block.language == "diff":
                file = folder / block.file
                file.write_text(apply(block.text, file.read_text("utf-8")), encoding="utf-8")
    return folder


def run(folder: Path, code: str) -> subprocess.CompletedProcess[str]:
    """Run Python in the copy, its compiled functions kept there."""
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join([str(folder), *(path for path in sys.path if path)]),
        "NUMBA_CACHE_DIR": str(folder / "cache"),
    }
    return subprocess.run(
        [sys.executable, "-c", code],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )


def test_there_is_a_page_for_each_socket() -> None:
    """Friction law, effect, control law and experiment have a page each."""
    names = {page.stem for page in PAGES}
    assert names == {"friction-law", "effect", "control-law", "experiment"}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_it_is_one_new_file_and_one_line(page: Path) -> None:
    """Each page changes the package by one new file and one line of an existing one."""
    named = [block for block in blocks(page) if block.file]
    assert all((ROOT / block.file).is_file() for block in named if block.language == "diff")
    inside = [b for b in named if b.language == "python" and b.file.startswith("rodless_")]
    (change,) = (block for block in named if block.language == "diff")
    assert len(inside) == 1
    assert not (ROOT / inside[0].file).exists()
    assert sum(line.startswith("+") for line in change.text.splitlines()) == 1


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_what_a_page_lets_its_reader_try_works(page: Path, extended: Path) -> None:
    """Every "Try it" in Python runs in the copy, and what it states holds."""
    tried = [b for b in blocks(page) if b.language == "python" and not b.file]
    commands = [b for b in blocks(page) if b.language == "sh"]
    assert tried or commands
    for block in tried:
        assert "assert " in block.text
        done = run(extended, block.text)
        assert done.returncode == 0, done.stderr


def test_the_new_experiment_runs_as_a_command(extended: Path) -> None:
    """`rodless experiment leakage` keeps its limit and writes picture, PDF and data."""
    (command,) = re.findall(
        r"rodless (experiment leakage .*)",
        (ROOT / "docs" / "how-to" / "experiment.md").read_text(encoding="utf-8"),
    )
    code = (
        "import sys; from rodless_lab.cli.main import main; "
        f"sys.argv[1:] = {command.split()!r}; main()"
    )
    done = run(extended, code)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "1 of 1 hold" in done.stdout
    assert {file.suffix for file in (extended / "leakage").glob("leakage.*")} == {
        ".png",
        ".pdf",
        ".csv",
    }


@extensive
@pytest.mark.ros
def test_the_new_law_controls_over_ros(extended: Path) -> None:
    """The law outside the package, in the node with its parameter file, commands as in Python."""
    values = yaml.safe_load((extended / "my_law.yaml").read_text(encoding="utf-8"))
    controller = values["/**/controller"]["ros__parameters"]
    reference = {"reference.type": "step", "reference.at": 0.1, "reference.target": 0.058}
    code = f"""
import numpy as np
from my_laws import PressureDamped
from rodless_control import references
from rodless_lab import closed_loop
from rodless_lab.harness import RigSession
from rodless_sim import RigParameters

if __name__ == "__main__":
    controller = {controller!r}
    with RigSession("lockstep", controller={{**controller, **{reference!r}}}, duration=0.5) as rig:
        found = rig.run()
    law = PressureDamped({{"damped.gain": controller["damped.gain"]}})
    step = references.step(0.0, 0.058, at=0.1)
    expected = closed_loop(RigParameters.preset("paper"), law, step, 0.5, 1e-3)
    assert np.ptp(found.voltage) > 1.0
    assert np.array_equal(found.voltage, expected.voltage)
"""
    done = run(extended, code)
    assert done.returncode == 0, done.stderr
