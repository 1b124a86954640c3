# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What a release through bloom and the ROS build farm needs of the tree."""

import re
import shutil
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest
from catkin_pkg.changelog import get_changelog_from_path
from catkin_pkg.package import parse_package
from catkin_pkg.package_version import (
    get_forthcoming_label,
    update_changelog_sections,
    update_versions,
)

ROOT = Path(__file__).parents[1]

# rosdep keys of this kind install with pip on Ubuntu; bloom refuses a package that has one.
PIP_KEYS = re.compile(r"(?<!python3)-pip$|^mcap|rosbags|pyarrow")


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """Return a copy of what catkin_prepare_release changes."""
    for name in ("package.xml", "setup.py", "CHANGELOG.rst"):
        shutil.copy(ROOT / name, tmp_path)
    return tmp_path


def test_a_release_can_be_prepared(tree: Path) -> None:
    """The steps of catkin_prepare_release, by its own functions: version and changelog move on.

    The new entry is what was forthcoming, under the new version and a date.
    """
    changelog = get_changelog_from_path(str(tree / "CHANGELOG.rst"), "rodless_sim")
    label = get_forthcoming_label(changelog.rst)
    assert label == "Forthcoming"
    update_versions({str(tree): parse_package(str(tree / "package.xml"))}, "8.9.10")
    path = str(tree / "CHANGELOG.rst")
    update_changelog_sections({"rodless_sim": (path, changelog, label)}, "8.9.10")
    assert parse_package(str(tree / "package.xml")).version == "8.9.10"
    assert 'version="8.9.10",' in (tree / "setup.py").read_text()
    released = get_changelog_from_path(path, "rodless_sim")
    assert "8.9.10" in [version for version, _, _ in released.foreach_version()]
    assert released.get_date_of_version("8.9.10") is not None
    forthcoming = (ROOT / "CHANGELOG.rst").read_text().split("Forthcoming\n", 1)[1]
    entries = re.findall(r"^\* ", forthcoming.split("\n---", 1)[0], re.M)
    (content,) = released.get_content_of_version("8.9.10")
    assert len(content.bullets) >= len(entries) > 0


def test_the_check_names_all_that_a_release_lacks(tmp_path: Path) -> None:
    """A placeholder in the manifest and a file without a header, both in one go; then nothing."""
    for name in ("Makefile", "package.xml", "LICENSE", ".ci/headers.py"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    manifest, new = tmp_path / "package.xml", tmp_path / "new.py"
    named = re.sub(r"[\w-]+\.example", "rodless.org", manifest.read_text())
    manifest.write_text(named.replace("rodless.org", "rodless.example", 1))
    new.write_text("LENGTH = 1\n")
    subprocess.run(["git", "init", "-q", tmp_path], check=True, capture_output=True)

    def check() -> tuple[bool, str]:
        command = ["make", "-s", "release-check", f"PYTHON={sys.executable}"]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        return done.returncode == 0, done.stdout + done.stderr

    passed, said = check()
    assert not passed
    for part in ("rodless.example", "put real names", str(new), "make headers"):
        assert part in said
    manifest.write_text(named)
    subprocess.run([sys.executable, ".ci/headers.py"], cwd=tmp_path, check=True)
    assert check()[0]


def test_no_dependency_is_installed_with_pip() -> None:
    """Every rosdep key is a package of ROS or of the system."""
    manifest = ElementTree.parse(ROOT / "package.xml").getroot()
    keys = {str(e.text) for e in manifest if e.tag.endswith("depend")}
    assert len(keys) > 10
    assert {key for key in keys if PIP_KEYS.search(key)} == set()


def test_the_manifest_is_valid_and_says_where_the_package_lives() -> None:
    """catkin_pkg reads it without a warning; it has the URLs and the file of the licence."""
    warnings: list[str] = []
    package = parse_package(str(ROOT / "package.xml"), warnings=warnings)
    assert warnings == []
    assert {url.type for url in package.urls} == {"website", "repository", "bugtracker"}
    assert [(str(one), one.file) for one in package.licenses] == [("Apache-2.0", "LICENSE")]
