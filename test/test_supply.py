# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Where the dependencies come from: the lock file, and the look-up of vulnerabilities."""

import re
import subprocess
import sys
from importlib.metadata import requires
from pathlib import Path

import pytest
from packaging.requirements import Requirement

ROOT = Path(__file__).parents[1]
LOCK = ROOT / "locked.txt"
PYTHONS = ("3.10", "3.11", "3.12", "3.13")


def entries() -> list[str]:
    """Return what the lock file says of each pin, on one line each, comments left out."""
    text = re.sub(r"^ *#.*\n", "", LOCK.read_text(encoding="utf-8"), flags=re.M)
    return text.replace("\\\n", " ").splitlines()


@pytest.fixture(scope="module")
def pins() -> list[Requirement]:
    """Return the pins."""
    return [Requirement(entry.partition(" --hash")[0]) for entry in entries()]


def test_every_pin_has_hashes_and_names_no_place_to_fetch_it_from() -> None:
    """One version each, with SHA-256 sums and nothing else: the registry is the user's choice."""
    assert len(entries()) > 50
    form = r"[\w.-]+==[\w.]+( ; [\w' .<>=*]+?)? +(--hash=sha256:[0-9a-f]{64} *)+"
    assert [entry for entry in entries() if not re.fullmatch(form, entry)] == []


@pytest.mark.parametrize("python", PYTHONS)
def test_the_lock_file_holds_what_setup_py_asks_for(pins: list[Requirement], python: str) -> None:
    """Each requirement of the installed package has one pin, within its bounds.

    On a distribution other than the locked one, jazzy, those of ROS are called otherwise.
    """
    versions = {"python_version": python, "python_full_version": f"{python}.0"}
    pinned: dict[str, str] = {}
    for pin in pins:
        if pin.marker is None or pin.marker.evaluate(versions):
            assert pin.name not in pinned
            pinned[pin.name] = str(pin.specifier).removeprefix("==")
    asked = [Requirement(line) for line in requires("rodless_sim") or [] if "extra ==" not in line]
    assert len(asked) > 5
    for one in asked:
        name = re.sub("^ros-[a-z]+-", "ros-jazzy-", one.name.lower())
        assert name in pinned
        assert pinned[name] in one.specifier


@pytest.mark.parametrize(
    ("said", "code", "expected"),
    [
        (
            '{"name": "numpy", "version": "1", "vulns": [{"id": "X-1", "fix_versions": ["2"]}]}',
            1,
            "numpy 1: X-1, fixed in 2\n"
            "locked.txt: 1 projects looked up, 1 of them vulnerable; 0 unknown to the service\n",
        ),
        (
            '{"name": "numpy", "version": "1", "vulns": []}, {"name": "q", "skip_reason": "?"}',
            0,
            "locked.txt: 1 projects looked up, 0 of them vulnerable; 1 unknown to the service\n",
        ),
        (None, 0, "locked.txt: not audited: ConnectionError: no route\n"),
    ],
    ids=["a vulnerability", "none", "no network"],
)
def test_only_a_vulnerability_fails_the_audit(
    tmp_path: Path, said: str | None, code: int, expected: str
) -> None:
    """A service that cannot be reached, or does not know a project, is said and let pass."""
    answer = f"print('{{\"dependencies\": [{said}]}}')"
    failure = "raise ConnectionError('no route')"
    (tmp_path / "pip_audit.py").write_text(failure if said is None else answer)
    done = subprocess.run(
        [sys.executable, str(ROOT / ".ci" / "audit.py"), "locked.txt"],
        check=False,
        capture_output=True,
        text=True,
        env={"PYTHONPATH": str(tmp_path)},
        timeout=60,
    )
    assert (done.stdout, done.returncode) == (expected, code)
