# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A first start that compiles, so that later ones are quick, and pytest outside this project."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from rodless_lab.session.session import RigSession


@pytest.fixture(scope="session")
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
