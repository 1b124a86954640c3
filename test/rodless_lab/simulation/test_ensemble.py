# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Many rigs at once: each as if it were alone, whatever the number of threads."""

import gc
import re
import threading
import weakref
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from rodless_base.parameters import ParameterError
from rodless_control import Measurement, PidParameters, ReferencePoint, references
from rodless_control.controller import LawError
from rodless_lab import closed_loop, draw, ensemble, run_metrics
from rodless_lab.simulation.in_order import AHEAD, in_order
from rodless_sim import RigParameters, Scenario, ScenarioError

STEP = references.step(0.0, 0.058, at=0.1)
RANGES = {"cylinder.moving_mass": (0.7, 2.0), "supply.pressure": (5e5, 7e5)}
NOISY = RigParameters.preset("calibrated").with_values({"sensors.position_noise": 2e-5})
FRICTION = [
    f"friction.{way}.{name}" for way in ("forward", "reverse") for name in ("static", "coulomb")
]
LAW = PidParameters.preset("calibrated")


def rigs(count: int) -> list[RigParameters]:
    """Random rigs with noise, each its own."""
    return list(draw(RANGES, count, NOISY, factors={"friction.*.static": (0.7, 1.3)}))


def test_each_rig_has_the_figures_of_its_own_closed_loop() -> None:
    """Bit for bit, and in the order of the rigs."""
    chosen = rigs(6)
    found = ensemble(chosen, LAW, STEP, duration=1.0)
    alone = [run_metrics(closed_loop(rig, LAW, STEP, 1.0, 1e-3)) for rig in chosen]
    for name, column in found.columns().items():
        expected = np.array([getattr(one, name) for one in alone])
        assert np.array_equal(column, expected, equal_nan=True), name
    assert len(set(found["final_error"])) == len(chosen)


@pytest.mark.parametrize("workers", [2, 5])
def test_figures_depend_neither_on_threads_nor_on_order(workers: int) -> None:
    """One thread or several, forwards or backwards: the same bits for the same rig."""
    chosen = rigs(12)
    single = ensemble(chosen, LAW, STEP, 0.5, workers=1).columns()
    several = ensemble(chosen, LAW, STEP, 0.5, workers=workers).columns()
    backwards = ensemble(chosen[::-1], LAW, STEP, 0.5, workers=workers).columns()
    for name, column in single.items():
        assert np.array_equal(column, several[name], equal_nan=True)
        assert np.array_equal(column, backwards[name][::-1], equal_nan=True)


def test_rigs_are_taken_from_a_generator_as_they_are_needed_and_let_go() -> None:
    """However many it yields, only as many exist at a time as the threads work ahead."""
    alive: list[weakref.ref[RigParameters]] = []
    most = 0

    def generated() -> Iterator[RigParameters]:
        nonlocal most
        for rig in draw(RANGES, 60, NOISY):
            alive.append(weakref.ref(rig))
            gc.collect(0)
            most = max(most, sum(one() is not None for one in alive))
            yield rig

    assert len(ensemble(generated(), LAW, STEP, 0.05, workers=2)) == 60
    assert most <= 2 * AHEAD + 2 * 2 + 2


def test_a_run_that_fails_leaves_the_others_their_figures() -> None:
    """A law that answers NaN for one rig alone: its place says why, its figures are NaN."""

    def law(measurement: Measurement, _reference: ReferencePoint) -> float:
        return float("nan") if measurement.supply_pressure < 4e5 else 5.08

    supplies = (6e5, 3e5, 6e5)
    chosen = [RigParameters({"supply.pressure": supply}) for supply in supplies]
    found = ensemble(chosen, law, STEP, 0.01)
    assert list(np.isnan(found["final_error"])) == [False, True, False]
    assert list(found.failures) == [1]
    assert "must be a finite number" in found.failures[1]


def test_a_failure_is_one_line_that_can_be_shown_and_kept() -> None:
    """Though the law has made its text itself: a table and a terminal take it as it is."""

    def law(_measurement: Measurement, _reference: ReferencePoint) -> float:
        raise LawError("no\nmore\x1b[31m\ud800")

    found = ensemble(rigs(1), law, STEP, 0.01)
    assert found.failures == {0: r"at 0 s: no more\x1b[31m\ud800"}


def test_what_is_no_rig_is_refused_as_in_closed_loop() -> None:
    """With the same words, where a dict of parameters stands among the rigs too."""
    given: Any = {"cylinder.moving_mass": 1.0}
    with pytest.raises(TypeError) as expected:
        closed_loop(given, LAW, STEP, 0.01, 1e-3)
    with pytest.raises(TypeError, match=re.escape(str(expected.value))):
        ensemble([*rigs(1), given], LAW, STEP, 0.01)
    # One rig, or the name of one, in place of several.
    for one in (RigParameters(), "paper", None, np.array(5.6)):
        with pytest.raises(TypeError, match=r"^rigs .* refused: must be a sequence of RigP"):
            ensemble(one, LAW, STEP, 0.01)  # type: ignore[arg-type]


def test_a_law_in_python_runs_rig_by_rig() -> None:
    """It may remember something: all of its updates come from one thread."""
    threads = set()

    def law(_measurement: Measurement, _reference: ReferencePoint) -> float:
        threads.add(threading.get_ident())
        return 5.5

    ensemble(rigs(6), law, STEP, 0.01, workers=3)
    assert threads == {threading.get_ident()}


@pytest.mark.parametrize("error", [ZeroDivisionError, StopIteration, SystemExit])
@pytest.mark.parametrize("faulty", [False, True])
def test_a_law_that_raises_fails_its_run_alone(error: type[BaseException], faulty: bool) -> None:
    """Each other rig has its figures; the failure names time, law, error and line.

    Step by step, as a fault has the rig run, too.
    """
    chosen = rigs(4)
    if faulty:
        chosen = [rig.with_values({"fault.position.offset": 1e-4}) for rig in chosen]
    begun: list[int] = []

    def law(measurement: Measurement, _reference: ReferencePoint) -> float:
        if measurement.stamp == 0:
            begun.append(0)
        if len(begun) == 2 and measurement.stamp >= 5_000_000:
            raise error("no more")
        return 5.5

    found = ensemble(chosen, law, STEP, 0.02)
    assert list(found.failures) == [1]
    assert re.fullmatch(
        rf"at 0\.005 s: .*law.* failed: {error.__name__}: no more \(test_ensemble\.py, line \d+\)",
        found.failures[1],
    )
    assert np.isnan(found["peak_error"]).tolist() == [False, True, False, False]


def test_a_scenario_that_ends_early_ends_the_ensemble_aloud() -> None:
    """One that raises StopIteration, as an iterator at its end, is no end of the rigs."""

    def scenario(_rig: RigParameters) -> None:
        raise StopIteration

    for workers in (1, 2):
        with pytest.raises(RuntimeError, match="StopIteration"):
            ensemble(rigs(4), LAW, STEP, 0.01, workers=workers, scenario=scenario)


def test_a_rig_whose_state_refuses_an_entry_fails_alone() -> None:
    """One that is stuck has not come past the new end. What none can follow still ends all."""
    stuck = NOISY.with_values(dict.fromkeys(FRICTION, 150.0))
    shorter = Scenario([(0.4, {"cylinder.stroke": 0.03})], "shorter")
    found = ensemble([NOISY, stuck], LAW, STEP, 0.5, scenario=lambda _: shorter)
    assert list(found.failures) == [0]
    assert re.match(r"shorter: entry 1: cylinder\.stroke: .*0\.03", found.failures[0])
    assert np.isnan(found["final_error"]).tolist() == [True, False]
    none = Scenario([(0.4, {"cylinder.stroke": 0.03, "cylinder.initial_position": 0.1})], "none")
    with pytest.raises(ScenarioError, match="none: entry 1: "):
        ensemble([NOISY, stuck], LAW, STEP, 0.5, scenario=lambda _: none)


@pytest.mark.parametrize("ranges", [{"cylinder.*mass": (1.0, 2.0)}, RANGES])
def test_two_ranges_of_one_parameter_are_refused(ranges: dict[str, object]) -> None:
    """As a range and a factor, or by two names: one of the two would be lost."""
    with pytest.raises(
        ValueError, match=r"^cylinder\.moving_mass: drawn by .* and by .*; keep one"
    ):
        list(draw(ranges, 2, NOISY, factors={"cylinder.moving_mass": (0.9, 1.1)}))


def test_a_compiled_law_runs_in_several_threads() -> None:
    """The run that waits in one thread goes on once a later one has begun in another."""
    other = threading.Event()

    def work(item: int) -> int:
        if item == 1:  # the first, 0, is worked on alone
            assert other.wait(60.0)
        elif item > 1:
            other.set()
        return item * item

    assert list(in_order(work, range(9), workers=2)) == [k * k for k in range(9)]


def test_an_exception_ends_the_work() -> None:
    """What has not begun never does, however long the list."""
    begun = []

    def work(item: int) -> int:
        begun.append(item)
        if item == 3:
            raise ValueError("no 3")
        return item

    with pytest.raises(ValueError, match="no 3"):
        list(in_order(work, range(10_000), workers=2))
    assert len(begun) < 100


def test_no_worker_is_refused() -> None:
    """In one line."""
    with pytest.raises(ValueError, match=r"^workers 0 refused: must be from 1 to 1000$"):
        ensemble(rigs(1), LAW, STEP, workers=0)
    with pytest.raises(ValueError, match=r"^workers np.timedelta64\(5,'s'\) refused: "):
        ensemble(rigs(1), LAW, STEP, workers=np.timedelta64(5, "s"))  # type: ignore[arg-type]


def test_progress_counts_the_runs() -> None:
    """After each of them."""
    counts: list[int] = []
    ensemble(rigs(4), LAW, STEP, 0.01, progress=counts.append)
    assert counts == [1, 2, 3, 4]


def test_the_table_has_units() -> None:
    """As every run that can be saved."""
    found = ensemble(rigs(2), LAW, STEP, 0.01)
    assert found.columns().keys() == found.units().keys()
    assert found.units()["air"] == "kg"
    frame = found.to_dataframe()
    assert list(frame.columns) == list(found.columns())
    assert len(frame) == 2


def test_drawn_rigs_are_the_same_each_time_and_each_its_own() -> None:
    """In their ranges, with seeds of their own; a shorter draw is the beginning of a longer one."""
    for method in ("random", "sobol"):
        eight = list(draw(RANGES, 8, seed=3, method=method))
        assert eight == list(draw(RANGES, 8, seed=3, method=method))
        assert eight[:5] == list(draw(RANGES, 5, seed=3, method=method))
        assert eight != list(draw(RANGES, 8, seed=4, method=method))
        assert len({rig["sensors.seed"] for rig in eight}) == 8
        assert all(0.7 <= rig.number("cylinder.moving_mass") <= 2.0 for rig in eight)


def test_a_latin_hypercube_has_one_rig_in_each_slice() -> None:
    """Of ten masses each tenth of the range has one."""
    masses = [
        rig.number("cylinder.moving_mass") for rig in draw(RANGES, 10, method="latin_hypercube")
    ]
    assert sorted(int((mass - 0.7) / 0.13) for mass in masses) == list(range(10))


def test_a_factor_changes_all_that_its_pattern_names_together() -> None:
    """The static friction of both directions keeps its proportion."""
    base = RigParameters.preset("calibrated")
    names = [name for name in base if name.endswith(".static")]
    assert len(names) == 2
    for rig in draw({}, 5, factors={"friction.*.static": (0.7, 1.3)}):
        factors = {rig.number(name) / base.number(name) for name in names}
        assert max(factors) - min(factors) < 1e-12
        assert 0.7 <= max(factors) <= 1.3


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({"ranges": {"supply.presure": (5e5, 6e5)}}, "did you mean supply.pressure"),
        ({"ranges": {"supply.pressure": (6e5, 5e5)}}, "the smaller one first"),
        ({"ranges": {"supply.pressure": 6e5}}, "must be (low, high)"),
        ({"ranges": {"supply.pressure": (0.0, 1.0)}}, "supply.pressure"),
        ({"ranges": RANGES, "method": "grid"}, "must be random, latin_hypercube, sobol"),
        ({"ranges": RANGES, "count": 0}, "count 0 refused"),
        ({"ranges": RANGES, "seed": -1}, "seed -1 refused"),
        ({"ranges": {}, "factors": {"friction.form": (1.0, 2.0)}}, "refused: no numbers"),
    ],
)
def test_a_draw_that_cannot_be_is_refused_in_one_line(
    arguments: dict[str, object], text: str
) -> None:
    """With the value, and what it must be."""
    with pytest.raises((ValueError, ParameterError)) as refusal:
        list(draw(**{"count": 3, **arguments}))  # type: ignore[arg-type]
    assert text in str(refusal.value)
    assert "\n" not in str(refusal.value)
