# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The fuzzer: its inputs end well, and it would notice one that does not."""

import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

FOLDER = Path(__file__).parent


@pytest.fixture
def fuzz(monkeypatch: pytest.MonkeyPatch) -> SimpleNamespace:
    """Return the fuzzer's modules, which find each other as in `python test/fuzz`."""
    monkeypatch.syspath_prepend(FOLDER)
    for name in ("draw", "target", "judge", "worker", "python_functions"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    import judge  # noqa: PLC0415
    import python_functions  # noqa: PLC0415
    import worker  # noqa: PLC0415

    return SimpleNamespace(judge=judge, worker=worker, functions=python_functions)


def multi_line() -> None:
    raise ValueError("two\nlines")


def endless() -> None:
    while True:
        pass


@pytest.mark.ros
@pytest.mark.slow
def test_odd_inputs_end_in_success_or_in_a_refusal_of_our_own() -> None:
    """A few thousand of each kind, always the same: functions, files, bags, callbacks, DDS."""
    done = subprocess.run(
        [sys.executable, str(FOLDER), "--smoke"],
        capture_output=True,
        text=True,
        timeout=3000.0,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.splitlines()[-1] == "nothing found"
    counts = {line.split()[0]: int(line.split()[1]) for line in done.stdout.splitlines()[:-1]}
    assert set(counts) == {
        "python", "files", "scenarios", "studies", "bags", "view", "nodes", "dds",
    }  # fmt: skip
    assert min(counts.values()) >= 100


def test_each_public_function_is_given_odd_arguments(fuzz: SimpleNamespace) -> None:
    """What is public is called by the fuzzer, or is listed as having nothing to call."""
    assert fuzz.functions.uncalled() == set()


@pytest.mark.parametrize(
    ("run", "found"),
    [
        (lambda: {}["a"], "KeyError out of no raise statement of ours"),
        (multi_line, "ValueError out of no raise statement of ours"),
        (lambda: (1.0, [float("nan")]), "accepted, with nan"),
        (endless, "not done after"),
    ],
    ids=["crash", "foreign error", "silent acceptance", "hang"],
)
def test_what_ends_badly_is_found(
    fuzz: SimpleNamespace, monkeypatch: pytest.MonkeyPatch, run: object, found: str
) -> None:
    """Crash, foreign error, a number that is none, and a hang."""
    monkeypatch.setattr(fuzz.judge, "SECONDS", 0.2)

    def bounded() -> None:
        with fuzz.judge.bounded():
            fuzz.judge.accepted(run)

    with pytest.raises(fuzz.judge.FoundError, match=found):
        bounded()


def test_too_much_memory_is_found(fuzz: SimpleNamespace, monkeypatch: pytest.MonkeyPatch) -> None:
    """By the largest size of the process before and after, here of the test's own (kB)."""
    sizes = iter([100_000, 500_000])
    largest = lambda _who: SimpleNamespace(ru_maxrss=next(sizes))  # noqa: E731
    monkeypatch.setattr(fuzz.judge.resource, "getrusage", largest)
    with pytest.raises(fuzz.judge.FoundError, match="takes 400 MB"), fuzz.judge.bounded():
        pass


def test_a_refusal_of_our_own_is_none(fuzz: SimpleNamespace) -> None:
    """One line that a raise statement of the project has raised."""
    from rodless_sim import RigParameters  # noqa: PLC0415

    assert not fuzz.judge.accepted(lambda: RigParameters({"supply.pressure": -1.0}))
    assert fuzz.judge.accepted(lambda: RigParameters()["supply.pressure"])


def test_the_fewest_changes_that_fail_are_reported(fuzz: SimpleNamespace) -> None:
    """Of twenty, the two without which nothing fails, in their order."""
    fewest = fuzz.worker.smallest(list(range(20)), lambda some: {3, 17} <= set(some))
    assert fewest == [3, 17]
