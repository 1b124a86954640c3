"""The fixture under test, and a first start that compiles, so that later ones are quick."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

# No test folder is on sys.path by itself; this one holds what its tests share.
sys.path.insert(0, str(Path(__file__).parent))

from rodless_lab.harness import RigSession


@pytest.fixture(scope="session", autouse=True)
def compiled() -> None:
    """Compile what the nodes need once, not in each of several at a time."""
    with RigSession():
        pass


@pytest.fixture
def run_pytest(tmp_path: Path) -> Callable[..., subprocess.Popen[str]]:
    """Return a function that starts pytest on files of ``tmp_path``, outside this project."""

    def run(*arguments: str) -> subprocess.Popen[str]:
        return subprocess.Popen(
            [
                *(sys.executable, "-m", "pytest", "-p", "rodless_pytest", "-p", "no:cacheprovider"),
                *("--rootdir", str(tmp_path), *arguments),
            ],
            cwd=tmp_path,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )

    return run
