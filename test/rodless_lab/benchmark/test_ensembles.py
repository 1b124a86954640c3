# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The benchmark of many rigs at once: what it reports, and that it can be ended."""

import shutil
from collections.abc import Callable

import pytest

from rodless_lab.benchmark import ensembles
from rodless_lab.simulation.in_order import cores


@pytest.mark.slow
def test_speed_scaling_and_memory_of_both_presets_are_reported() -> None:
    """And beside them how the C file grows with the cores, where there is a compiler."""
    found = ensembles.bench_ensembles(lambda: None, few=4, many=8, of_c=4)
    expected = [
        f"{preset}, {what}"
        for preset in ("paper", "calibrated")
        for what in (
            "4 rigs on one core, rig-seconds per second",
            f"4 rigs, {cores()} cores ÷ one",
            "8 rigs, rig-seconds per second",
            "memory after 4 rigs (MB)",
            "memory after 8 rigs (MB)",
        )
    ]
    if shutil.which("cc"):
        expected.append(f"C file, {cores()} cores ÷ one")
    assert list(found) == expected
    assert all(value > 0.0 for value in found.values())


@pytest.mark.slow
def test_ctrl_c_ends_it_within_a_rig() -> None:
    """What is asked before each rig raises: no further one is begun."""
    asked: list[int] = []

    def check() -> None:
        asked.append(0)
        if len(asked) == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        ensembles.bench_ensembles(check, few=4, many=8, of_c=4)
    assert len(asked) == 3


@pytest.mark.parametrize("workers", [1, 3, 7, 8, 12])
def test_the_c_file_is_timed_as_often_as_it_is_said(
    workers: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On any number of cores 8 runs take 8 s where each takes 1 s and they are done in turn."""
    runs: list[object] = []

    def seconds(work: Callable[[], object]) -> float:
        work()
        return float(len(runs))

    monkeypatch.setattr(ensembles, "_seconds", seconds)
    assert ensembles._of_c_seconds(runs.append, 8, workers) == pytest.approx(8.0)
    assert 8 <= len(runs) < 8 + workers


@pytest.mark.parametrize(
    ("seconds", "expected"),
    [
        # The second round was disturbed on one core, the third on all.
        ([(8.0, 4.0), (12.0, 4.0), (8.0, 7.0)], (8.0, 4.0)),
        ([(9.0, 4.5), (9.0, 4.5), (9.0, 4.5)], (9.0, 4.5)),
    ],
)
def test_the_round_with_the_median_ratio_counts(
    seconds: list[tuple[float, float]],
    expected: tuple[float, float],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """One core and all are measured in turn; a disturbed round does not decide."""
    monkeypatch.setattr(ensembles, "ROUNDS", len(seconds))
    left = iter([one for pair in seconds for one in pair])
    timed: Callable[[int | None], float] = lambda _: next(left)  # noqa: E731
    assert ensembles.in_turn(timed, lambda: None) == expected
