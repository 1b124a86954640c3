# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Speed factor, lag and what is said of them, on a clock that the test moves."""

import pytest

from rodless_sim.node.pace import ENOUGH, GOOD_REPORTS, Pace, PaceMeter, PaceNews

PERIOD = 1_000_000
POLL = 20_000_000
REPORT = 1_000_000_000


class Plant:
    """Plant time that advances by whole periods at ``factor`` plant s per wall-clock s."""

    def __init__(self, speed: float = 1.0) -> None:
        self.wall = 987_654_321
        self.exact = 0.0
        self.running = False
        self.meter = PaceMeter(speed, PERIOD, lambda: self.wall)
        self.poll()

    @property
    def time(self) -> int:
        """Plant time in ns."""
        return int(self.exact) // PERIOD * PERIOD

    def poll(self) -> None:
        """Let the meter see it."""
        self.meter.observe(self.time, self.running)

    def run(self, seconds: float, factor: float) -> None:
        """Run for ``seconds`` of wall clock."""
        self.running = True
        self.poll()
        for _ in range(round(seconds * REPORT / POLL)):
            self.wall += POLL
            self.exact += factor * POLL
            self.poll()

    def pause(self, seconds: float) -> None:
        """Stand still by request."""
        self.running = False
        self.poll()
        self.wall += round(seconds * REPORT)
        self.poll()


@pytest.mark.parametrize("speed", [0.01, 1.0, 10.0])
def test_a_plant_in_time_has_no_lag(speed: float) -> None:
    """For an hour it keeps up: the factor is the speed asked for, the lag 0, nothing is said."""
    plant, news = Plant(speed), PaceNews(speed, 1e-3)
    plant.run(1.0, speed)
    assert plant.meter.report().falls_behind is None, "it started within this report"
    for _ in range(100):
        plant.run(36.0, speed)
        pace = plant.meter.report()
        assert pace.speed_factor == pytest.approx(speed, rel=3e-3)
        assert pace.lag == 0.0
        assert pace.falls_behind is False
        assert news.hear(pace) is None


@pytest.mark.parametrize("speed", [0.5, 1.0, 10.0])
def test_a_plant_at_87_per_cent_lags_by_what_is_missing(speed: float) -> None:
    """Each wall-clock second costs 0.13 times the speed, less the one period that is in time."""
    plant = Plant(speed)
    plant.run(1.0, 0.87 * speed)
    plant.meter.report()
    for second in range(2, 12):
        plant.run(1.0, 0.87 * speed)
        pace = plant.meter.report()
        assert pace.speed_factor == pytest.approx(0.87 * speed, rel=3e-3)
        assert pace.lag == pytest.approx(0.13 * speed * second - 1e-3, abs=1.1e-3)
        assert pace.falls_behind is True


def test_a_plant_at_97_per_cent_lags_but_does_not_fall_behind() -> None:
    """What is missing adds up and is shown; there is a warning below ``ENOUGH`` alone."""
    plant = Plant()
    plant.run(1.0, 0.97)
    plant.meter.report()
    plant.run(1.0, 0.97)
    pace = plant.meter.report()
    assert pace.lag == pytest.approx(0.06 - 1e-3, abs=1.1e-3)
    assert pace.falls_behind is False
    assert plant.meter.report().speed_factor == 0.0, "no time has passed since"


def test_a_long_period_is_no_lag() -> None:
    """A plant with one sample in 100 s of wall clock does not fall behind in between."""
    wall = [0]
    meter = PaceMeter(0.01, 10**9, lambda: wall[0])
    for second in range(1000):
        wall[0] = second * 10**9
        meter.observe(second // 100 * 10**9, running=True)
        pace = meter.report()
        assert not pace.falls_behind
        assert pace.lag == 0.0


def test_a_pause_does_not_count_and_a_resumed_plant_starts_without_lag() -> None:
    """The lag before stays to be seen during the pause; afterwards it counts anew."""
    plant = Plant()
    plant.run(2.0, 0.5)
    assert plant.meter.report().lag == pytest.approx(1.0, abs=2e-3)
    plant.pause(60.0)
    pace = plant.meter.report()
    assert pace.lag == pytest.approx(1.0, abs=2e-3)
    assert pace.speed_factor == 0.0
    assert pace.falls_behind is None
    plant.run(1.0, 1.0)
    pace = plant.meter.report()
    assert pace.lag == 0.0
    assert pace.speed_factor == pytest.approx(1.0, rel=2e-3)
    assert pace.falls_behind is None, "it was paused within this report"


def test_a_reset_starts_anew() -> None:
    """Time that jumps back is no fault: the lag counts from there, the factor stays positive."""
    plant = Plant()
    plant.run(10.0, 0.5)
    plant.meter.report()
    plant.run(0.5, 1.0)
    plant.exact = 0.0
    plant.run(0.5, 1.0)
    pace = plant.meter.report()
    assert pace.lag == 0.0
    assert pace.speed_factor == pytest.approx(1.0, abs=0.03)
    assert pace.falls_behind is None


def test_in_lock_step_there_is_a_factor_but_no_lag() -> None:
    """As fast as the commands come, whether that is 7 times real time or 0.02 times."""
    plant = Plant(speed=0.0)
    for factor in (7.0, 0.02):
        plant.run(5.0, factor)
        pace = plant.meter.report()
        assert pace.speed_factor == pytest.approx(factor, rel=2e-2)
        assert pace.lag == 0.0
        assert not pace.falls_behind


def paced(factor: float, lag: float = 0.0) -> Pace:
    """A report of a plant that ran throughout at speed 1."""
    return Pace(factor, lag, factor < ENOUGH)


def test_falling_behind_is_said_once_with_how_much_why_and_the_way_out() -> None:
    """However long it lasts, one warning; a pause in between does not end it."""
    news = PaceNews(1.0, 1e-3)
    said = news.hear(paced(0.87, 0.13))
    assert said is not None
    assert news.behind
    for words in ("0.87", "0.130 s late", "time.period 0.001 s", "smaller time.speed", "programs"):
        assert words in said
    for _ in range(10):
        assert news.hear(paced(0.5)) is None
        assert news.hear(Pace(0.0, 0.0, None)) is None


def test_keeping_up_again_is_said_once_when_it_lasts() -> None:
    """A machine at its limit does not change its mind every second."""
    news = PaceNews(1.0, 1e-3)
    assert news.hear(paced(0.87)) is not None
    for _ in range(GOOD_REPORTS - 1):
        assert news.hear(paced(1.0)) is None
    assert news.hear(paced(0.9)) is None
    said = [news.hear(paced(1.0, 0.25)) for _ in range(GOOD_REPORTS + 5)]
    assert [k for k, line in enumerate(said) if line] == [GOOD_REPORTS - 1]
    assert "keeps up again; total lag 0.250 s" in str(said[GOOD_REPORTS - 1])
    assert not news.behind


def test_a_reset_forgets_that_the_plant_fell_behind() -> None:
    """One that keeps up is well at once, without a line; one that does not is news again."""
    news = PaceNews(1.0, 1e-3)
    assert news.hear(paced(0.87)) is not None
    assert news.behind
    news.clear()
    assert not news.behind
    assert news.hear(paced(1.0)) is None
    assert news.hear(paced(0.87)) is not None
