# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What `rodless rig` refuses before it starts anything, and what it says of a rig not ready."""

import importlib.util
import os
import signal
from pathlib import Path

import pytest
from extent import extensive
from running import StartProcess

from rodless_lab.session.observer import Observer

# Both nodes have two seconds to end.
STOP_SECONDS = 4.0


def test_what_cannot_be_is_refused_before_anything_starts(
    rodless: StartProcess, tmp_path: Path
) -> None:
    """A bag that exists, a supply in the wrong unit: exit code 2, and no node has said a word."""
    for options, text in (
        (("--record", str(tmp_path)), "exists already; a bag is never written over"),
        (("--supply-pressure", "6"), "supply.pressure: 6.0 refused"),
    ):
        with rodless("rig", *options) as rig:
            assert rig.wait() == 2
            assert text in rig.output
            assert "[plant]" not in rig.output


@extensive
def test_a_second_rig_of_one_name_is_refused(rodless: StartProcess, observer: Observer) -> None:
    """It would disturb the first, which does not hear of it."""
    with rodless("rig", "--namespace", "taken") as first:
        observer.wait(lambda: "ready: " in first.output, "the first rig")
        with rodless("rig", "--namespace", "/taken/") as second:
            assert second.wait() == 2
            assert "runs already in namespace /taken" in second.output
            assert "--namespace" in second.output
        with rodless("view", "--rig", "--namespace", "taken", "--port", "0") as view:
            assert view.wait() == 2
            has_pages = importlib.util.find_spec("nicegui") is not None
            said = "runs already in namespace /taken" if has_pages else "rodless_sim[view]"
            assert said in view.output
        assert observer.counter("/taken/plant", "nodes of this name", fresh=True) == 1
        first.signal(signal.SIGINT)
        assert first.wait(STOP_SECONDS) == 0


def test_a_law_that_does_not_return_is_named(
    rodless: StartProcess,
    observer: Observer,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The controller cannot say so itself; the rig does, and does not call itself ready."""
    (tmp_path / "endless_laws.py").write_text(
        "from rodless_control import Law\n\n\n"
        "class Endless(Law):\n"
        "    def update(self, measurement, reference, interval):\n"
        "        while True:\n"
        "            pass\n"
    )
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)
    file = tmp_path / "endless.yaml"
    file.write_text("controller:\n  ros__parameters: {controller.law: endless_laws:Endless}\n")
    with rodless("rig", "--namespace", "endless", "--parameters", str(file)) as rig:
        observer.wait(lambda: "not ready: " in rig.output, "the rig to say why it is not ready")
        assert "/endless/controller: silent: " in rig.output
        assert "a law that does not return" in rig.output
        assert "\nready: " not in rig.output
        rig.signal(signal.SIGINT)
        assert rig.wait() == 0
