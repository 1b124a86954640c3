# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.


"""A plant waits for another process that compiles, as long as nobody asks it to stop."""

import errno
import os
import subprocess
import sys
from collections.abc import Iterable
from types import SimpleNamespace
from typing import cast

import pytest
from ended import ended

from rodless_base.start import Stop, StoppedError
from rodless_sim import Rig, RigParameters, precompile
from rodless_sim.precompile import compile_changes, compile_unless_stopped, is_compiled

PAPER = RigParameters()
DROOP = RigParameters({"supply.droop": 1e4})

GOES_ON = cast(Stop, SimpleNamespace(requested=False))
ASKED = cast(Stop, SimpleNamespace(requested=True))


class Others:
    """Stands for the processes that compile, which end as they are told."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, code: str) -> None:
        """Nothing is there before them."""
        self.code = code
        self.asked: list[list[RigParameters]] = []
        monkeypatch.setattr(precompile, "is_compiled", lambda _: False)
        monkeypatch.setattr(precompile, "equations_are_kept", lambda _: False)
        monkeypatch.setattr(precompile, "compile_elsewhere", self._start)

    def _start(
        self, _before: RigParameters, changed: Iterable[RigParameters], niceness: int
    ) -> "subprocess.Popen[str]":
        assert niceness == 0
        self.asked.append([*changed])
        return ended(self.code)


def test_what_is_there_is_not_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither another process nor a word."""
    compile_changes(PAPER, [PAPER])
    monkeypatch.delattr(precompile, "compile_elsewhere")
    said: list[str] = []
    compile_unless_stopped(PAPER, [PAPER], ASKED, said.append)
    assert said == []


@pytest.mark.parametrize(
    ("code", "words"),
    [("raise SystemExit('no room')", "(no room)"), ("", "(exit code 0)"), ("1 / 0", "division")],
)
def test_what_another_process_has_not_compiled_is_said(
    monkeypatch: pytest.MonkeyPatch, code: str, words: str
) -> None:
    """Also where that calls itself well: what counts is whether it is there."""
    Others(monkeypatch, code)
    said: list[str] = []
    compile_unless_stopped(PAPER, [DROOP], GOES_ON, said.append)
    first, second = said
    assert first.startswith("compiling, which takes about a minute")
    assert second.startswith("no other process could compile the equations of these parameters")
    assert words in second


def test_where_no_process_can_be_started_that_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    """With the reason of the system."""
    Others(monkeypatch, "")

    def none(*_arguments: object, **_options: object) -> None:
        raise OSError(errno.ENOMEM, os.strerror(errno.ENOMEM))

    monkeypatch.setattr(precompile, "compile_elsewhere", none)
    said: list[str] = []
    compile_unless_stopped(PAPER, [DROOP], GOES_ON, said.append)
    assert os.strerror(errno.ENOMEM) in said[1]


def test_each_kind_of_equations_is_asked_for_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """However many sets of parameters a scenario has: the request is never longer than a pipe."""
    others = Others(monkeypatch, "")
    many = [RigParameters({"supply.droop": float(1000 + one)}) for one in range(50)]
    compile_unless_stopped(PAPER, [PAPER, *many], GOES_ON, lambda _: None)
    (asked,) = others.asked
    assert [one.number("supply.droop") > 0 for one in asked] == [False, True]


def test_a_request_to_stop_ends_the_other_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is waited for as well, and what it was told by is closed."""
    Others(monkeypatch, "")
    process = subprocess.Popen(
        [sys.executable, "-I", "-S", "-c", "import time; time.sleep(600)"],
        stdin=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    monkeypatch.setattr(precompile, "compile_elsewhere", lambda *_, **__: process)
    with pytest.raises(StoppedError):
        compile_unless_stopped(PAPER, [DROOP], ASKED, lambda _: None)
    assert process.returncode == -9
    assert process.stdin is not None
    assert process.stdin.closed


def test_what_fails_because_of_the_request_is_not_called_a_failure(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Ctrl-C in a terminal reaches a process that is just being started, too."""
    Others(monkeypatch, "raise SystemExit('ended by Ctrl-C')")
    said: list[str] = []
    with pytest.raises(StoppedError):
        compile_unless_stopped(PAPER, [DROOP], ASKED, said.append)
    assert len(said) == 1


def test_what_is_cut_short_counts_as_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    """A rig is marked as compiled once it has done all that a plant does."""
    marks: list[object] = []
    monkeypatch.setattr(precompile, "_mark", marks.append)

    def interrupt(_rig: Rig) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(Rig, "free_air_flow", property(interrupt))
        with pytest.raises(KeyboardInterrupt):
            compile_changes(PAPER, [PAPER])
    assert marks == []
    compile_changes(PAPER, [PAPER, DROOP])
    assert len(marks) == 2
    assert marks[0] != marks[1]


def test_what_is_compiled_here_is_marked() -> None:
    """Each kind of equations by itself."""
    compile_changes(PAPER, [PAPER, DROOP])
    assert is_compiled(PAPER)
    assert is_compiled(DROOP)
