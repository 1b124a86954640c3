# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A law that takes longer than the samples are apart: which samples are left out, and what is said.

The node itself runs in test_slow_law.py; here time is simulated.
"""

import pytest

from rodless_control.node.law_pace import BACKLOG, LawPace


def run(
    pace: LawPace, law_time: float, count: int, interval: float = 1e-3, start: float = 0.0
) -> list[float]:
    """Let samples come every ``interval`` s to one that answers in ``law_time``.

    Returns how long each answered one has waited. A skipped one takes 20 µs.
    """
    now, waits = start, []
    for k in range(count):
        sent = k * interval
        now = max(now, sent)
        pace.see(sent)
        if pace.must_skip(sent, now):
            now += 20e-6
        else:
            waits.append(now - sent)
            pace.took(law_time)
            now += law_time
    return waits


def test_a_law_that_keeps_up_is_given_every_sample() -> None:
    """Nothing is skipped, and nothing said."""
    pace = LawPace()
    assert len(run(pace, 0.8e-3, 5000)) == 5000
    assert pace.skipped == 0
    assert pace.news("law Quick") is None


def test_a_law_that_is_too_slow_is_given_the_newest_samples() -> None:
    """5 ms for each sample of 1 ms: soon one in five, and those have waited a sample at most."""
    pace = LawPace()
    waits = run(pace, 5e-3, 20_000)
    assert max(waits) < 4.0 * BACKLOG
    assert max(waits[200:]) <= 1e-3 + 1e-9
    assert len(waits) == pytest.approx(20_000 / 5, rel=0.1)
    assert pace.news("law Slow") == (
        "law Slow takes 5 ms per sample of 1 ms: samples skipped; make it faster, or lengthen "
        "time.period"
    )
    assert pace.news("law Slow") is None


@pytest.mark.parametrize("stall", [0.5, 5.0])
def test_a_law_that_waits_now_and_then_is_named(stall: float) -> None:
    """Once in 300 samples: that it is quick otherwise does not put it on the machine."""
    pace, now, k, said = LawPace(), 0.0, 0, list[str | None]()
    asked = calls = 0
    while now < 30.0:
        k += 1
        now = max(now, k * 1e-3)
        pace.see(k * 1e-3)
        if pace.must_skip(k * 1e-3, now):
            now += 20e-6
        else:
            calls += 1
            took = stall if calls % 300 == 0 else 8e-6
            pace.took(took)
            now += took
        if now > asked + 1.0:
            asked = int(now)
            said.append(pace.news("law Now"))
    news = [one for one in said if one is not None]
    assert len(news) >= 3
    for one in news:
        assert f"but once took {stall * 1e3:g} ms: samples skipped; it waited, or" in one


@pytest.mark.parametrize("law_time", [0.2, 1.0])
def test_a_very_slow_law_is_noticed_within_seconds(law_time: float) -> None:
    """Three answers tell."""
    pace = LawPace()
    assert len(run(pace, law_time, 10_000)) <= 10.0 / law_time + 3


@pytest.mark.parametrize("step", [3600.0, -3600.0])
def test_a_wall_clock_that_is_set_skips_nothing(step: float) -> None:
    """Forward: the samples under way seem to be an hour old. Back: they come from the future."""
    pace = LawPace()
    for k in range(2000):
        sent = k * 1e-3 + (step if k >= 1000 else 0.0)
        received = sent + 1e-4
        now = received + 1e-4 + (step if 997 <= k < 1000 else 0.0)
        pace.see(sent)
        assert not pace.must_skip(received, now)
        pace.took(1e-4)
    assert pace.skipped == 0


def test_a_slow_law_is_noticed_after_the_wall_clock_was_set_back() -> None:
    """A backlog that began just before then does not count as begun in an hour."""
    pace = LawPace()
    assert not pace.must_skip(0.0, 3600.0 + 2.0 * BACKLOG)
    waits = run(pace, 5e-3, 20_000)
    assert max(waits[200:]) <= 1e-3 + 1e-9


def test_a_stall_that_is_over_skips_nothing() -> None:
    """Half a second in which nothing ran is caught up with, sample by sample."""
    pace = LawPace()
    assert len(run(pace, 0.1e-3, 5000, start=0.5)) == 5000
    assert pace.skipped == 0


def test_a_plant_that_waits_for_each_answer_loses_no_sample() -> None:
    """In lock-step a slow law has no backlog; nor has one that was stopped for nine seconds."""
    pace, now = LawPace(), 0.0
    for k in range(300):
        received = now
        now += 9.0 if k % 100 == 50 else 0.1e-3
        pace.see(received)
        assert not pace.must_skip(received, now)
        pace.took(5e-3)
        now += 5e-3
    assert pace.skipped == 0


def test_a_law_that_has_become_quick_is_given_every_sample_again() -> None:
    """Once no sample had to be skipped for one period of the diagnostics."""
    pace = LawPace()
    run(pace, 5e-3, 1000)
    assert pace.news("law Slow") is not None
    assert pace.news("law Slow") is None
    assert len(run(pace, 0.1e-3, 1000)) == 1000


def test_a_machine_that_is_too_busy_is_not_blamed_on_the_law() -> None:
    """The law takes 0.1 ms of each sample; the rest of the process takes 5."""
    pace, now = LawPace(), 0.0
    for k in range(1000):
        now = max(now, k * 1e-3)
        pace.see(k * 1e-3)
        if not pace.must_skip(k * 1e-3, now):
            pace.took(1e-4)
            now += 5e-3
    news = pace.news("law Quick")
    assert news is not None
    assert news.startswith("machine too busy: samples skipped (law Quick takes 0.1 ms")
