# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless view` before there is a page."""

import subprocess
import sys
from pathlib import Path

import pytest

from rodless_base.start import Stop
from rodless_lab.cli import view


def test_without_its_library_it_says_how_to_get_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """In one line, with the extra's name."""
    monkeypatch.setitem(sys.modules, "nicegui", None)
    assert view.main([], Stop.__new__(Stop)) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "pip install 'rodless_sim[view]'" in error


@pytest.mark.parametrize("port", ["-1", "65536", "1.5", "x"])
def test_a_port_that_cannot_be_is_refused(port: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Before anything is started."""
    with pytest.raises(SystemExit):
        view.main(["--port", port], Stop.__new__(Stop))
    assert port in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["a", "b", "c"], "more than two bags"),
        (["--folder", "nowhere"], "no such folder"),
        (["nowhere"], "nowhere"),
        (["--namespace", "1"], "--namespace '1'"),
        (["bag", "--host", "a..b"], "a..b:8080: cannot be listened on: no name that a host can"),
        (["bag", "--host", "a" * 64], "cannot be listened on: no name that a host can have"),
    ],
)
def test_what_cannot_be_shown_is_refused_in_one_line(
    arguments: list[str],
    reason: str,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """With exit code 2."""
    if "--host" in arguments:
        app = pytest.importorskip("rodless_lab.view.app")
        monkeypatch.setattr(app, "open_playback", lambda _: None)
    monkeypatch.chdir(tmp_path)
    stop = Stop.__new__(Stop)
    stop.requested = False
    assert view.main(arguments, stop) == 2
    error = capsys.readouterr().err
    assert reason in error
    assert error.count("\n") == 1


def test_a_preset_of_no_rig_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    """It would change nothing: the rig that is joined has its own."""
    with pytest.raises(SystemExit) as ended:
        view.main(["--preset", "calibrated"], Stop.__new__(Stop))
    assert ended.value.code == 2
    assert "error: --preset is of --rig; add --rig;" in capsys.readouterr().err
    assert view._options(["--preset", "calibrated", "--rig"]).preset == "calibrated"
    assert view._options(["--rig"]).preset == "paper"


def test_the_other_verbs_do_not_load_the_pages() -> None:
    """They stay as quick as they were."""
    script = (
        "import sys, rodless_lab.cli.main, rodless_lab.cli.view, rodless_lab.cli.status\n"
        "assert 'nicegui' not in sys.modules and 'rclpy' not in sys.modules\n"
    )
    subprocess.run([sys.executable, "-c", script], check=True, timeout=120)
