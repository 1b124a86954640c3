# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""One target in a process of its own: inputs by number, each bounded, failures made small."""

import argparse
import faulthandler
import json
import resource
import sys
import time
import warnings
from collections.abc import Callable
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from traceback import format_exception
from typing import Any

sys.path.append(str(Path(__file__).parents[1] / "shared"))

from draw import Draw
from judge import FoundError, accepted, bounded
from target import Change, Target

from rodless_base.one_line import in_one_line

TARGETS = {
    "python": "python_functions:PythonFunctions",
    "files": "parameter_files:ParameterFiles",
    "scenarios": "scenario_files:ScenarioFiles",
    "studies": "study_files:StudyFiles",
    "bags": "bag_files:BagFiles",
    "view": "view_requests:ViewRequests",
    "nodes": "node_callbacks:NodeCallbacks",
    "dds": "over_dds:OverDds",
}

# Wall-clock s after which an input hangs beyond what can be interrupted: the process ends there.
HANG = 150.0

# Address space beyond what the process has when it begins, in bytes.
ADDRESS_SPACE = 4 << 30

# Different failures after which there is enough to mend.
MOST_FAILURES = 20

# Seconds between two writings of the report, which also count as heartbeats.
REPORT_PERIOD = 1.0


class Work:
    """Runs inputs and keeps the report."""

    def __init__(self, given: argparse.Namespace) -> None:
        """Prepare the target."""
        (self._name,) = given.target
        self._given = given
        self._report: dict[str, Any] = {
            "inputs": 0, "accepted": 0, "failures": [], "ended": False, "memory": 0,
            "next": given.first,
        }  # fmt: skip
        self._write()
        module, kind = TARGETS[self._name].split(":")
        self.target: Target = getattr(import_module(module), kind)(Path.cwd())
        self._seen: set[str] = set()

    def run(self) -> None:
        """Run inputs until the time, or their number, is up."""
        given = self._given
        if not accepted(lambda: self.target.run([])):
            raise FoundError("the good input is refused")
        _limit_memory()
        end, written = time.monotonic() + given.seconds, 0.0
        number = given.first
        while time.monotonic() < end if given.count is None else number < given.first + given.count:
            now = time.monotonic()
            if now > written + REPORT_PERIOD:
                written = now
                self._report["next"] = number
                self._write()
                # Not for each input, as it starts a thread.
                faulthandler.dump_traceback_later(HANG, exit=True)
            self._one(number)
            number += 1
            if len(self._report["failures"]) >= MOST_FAILURES:
                break
        faulthandler.cancel_dump_traceback_later()
        self._report["ended"] = True
        self._write()

    def _one(self, number: int) -> None:
        changes = self.target.draw(Draw(f"{self._name} {self._given.seed} {number}"))
        self._report["inputs"] += self.target.weight(changes)
        failure = self._failure(changes)
        if failure is None:
            return
        text, place = failure
        # One of a kind is enough.
        if place in self._seen:
            return
        self._seen.add(place)
        fewest = smallest(changes, lambda some: self._fails_at(some, place))
        self._report["failures"].append(
            {"number": number, "text": text, "changes": _spelled(fewest)}
        )
        self._write()

    def _failure(self, changes: list[Change]) -> tuple[str, str] | None:
        """Return what is wrong with an input, and where, or None."""
        try:
            with bounded():
                self._report["accepted"] += accepted(lambda: self.target.run(changes))
        except Exception as error:
            if error.__cause__ is None and isinstance(error, FoundError):
                return str(error), f"{in_one_line(str(error))[:40]} {changes[0]!s:.60}"
            cause = error.__cause__ or error
            *_, last = format_exception(cause, limit=-2)
            return f"{error}: {in_one_line(last)}; {_place(cause)}", _place(cause)
        return None

    def _fails_at(self, changes: list[Change], place: str) -> bool:
        failure = self._failure(changes)
        return failure is not None and failure[1] == place

    def _write(self) -> None:
        self._report["memory"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1000
        partial = self._given.worker.with_suffix(".part")
        partial.write_text(json.dumps(self._report), encoding="utf-8")
        partial.replace(self._given.worker)


def _place(error: BaseException) -> str:
    traceback = error.__traceback__
    while traceback is not None and traceback.tb_next is not None:
        traceback = traceback.tb_next
    where = (
        "" if traceback is None else (traceback.tb_frame.f_code.co_filename, traceback.tb_lineno)
    )
    return f"{type(error).__name__} {where}"


def _spelled(changes: list[Change]) -> str:
    limit = sys.get_int_max_str_digits()
    sys.set_int_max_str_digits(0)
    try:
        return in_one_line(repr(changes))
    finally:
        sys.set_int_max_str_digits(limit)


def smallest(changes: list[Change], fails: Callable[[list[Change]], bool]) -> list[Change]:
    """Return the fewest changes that still fail: halves are left out, then ever smaller parts."""
    size = max(len(changes) // 2, 1)
    while size:
        at = 0
        while at < len(changes):
            fewer = changes[:at] + changes[at + size :]
            if fewer and fails(fewer):
                changes = fewer
            else:
                at += size
        size //= 2
    return changes


def _limit_memory() -> None:
    with suppress(OSError, ValueError):
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
        limit = pages * resource.getpagesize() + ADDRESS_SPACE
        resource.setrlimit(resource.RLIMIT_AS, (limit, resource.getrlimit(resource.RLIMIT_AS)[1]))


def work(given: argparse.Namespace) -> None:
    """Fuzz one target, and report to the file ``given.worker``."""
    faulthandler.enable()
    warnings.simplefilter("ignore")
    one = Work(given)
    try:
        one.run()
    finally:
        one.target.close()
