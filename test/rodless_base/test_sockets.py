# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Modules that a parameter chooses by name: what is wrong with one is said with its name."""

import sys
from pathlib import Path

import pytest

from rodless_base.sockets import choices

GOOD = """
from rodless_base.kernels import kernel
NAME = "good"
@kernel
def force(x):
    return x
"""


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the folder of an empty package, `socket_modules`."""
    monkeypatch.syspath_prepend(tmp_path)
    for name in [name for name in sys.modules if name.startswith("socket_modules")]:
        monkeypatch.delitem(sys.modules, name)
    folder = tmp_path / "socket_modules"
    folder.mkdir()
    (folder / "__init__.py").write_text("", encoding="utf-8")
    (folder / "good.py").write_text(GOOD, encoding="utf-8")
    return folder


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        (GOOD, r"socket_modules\.odd: NAME 'good' is that of socket_modules\.good"),
        (GOOD.replace("NAME", "NAMES"), r"socket_modules\.odd: no NAME"),
        (
            GOOD.replace("@kernel", "").replace('"good"', '"odd"'),
            r"socket_modules\.odd \(odd\): force is missing or not compiled; decorate it",
        ),
    ],
)
def test_a_module_that_cannot_be_chosen_is_named(package: Path, text: str, complaint: str) -> None:
    """With the way out, where the package is imported."""
    (package / "odd.py").write_text(text, encoding="utf-8")
    with pytest.raises(TypeError, match=rf"^{complaint}") as refusal:
        choices("socket_modules", ("good", "odd"), ("force",))
    assert "\n" not in str(refusal.value)


def test_sound_modules_come_in_their_order(package: Path) -> None:
    """Under names of their own."""
    (package / "other.py").write_text(GOOD.replace('"good"', '"other"'), encoding="utf-8")
    found = choices("socket_modules", ("other", "good"), ("force",))
    assert [module.NAME for module in found] == ["other", "good"]
