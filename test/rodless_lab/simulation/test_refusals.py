# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""References, durations and sets that no run can have; runs that are copied and pickled."""

import copy
import math
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rodless_base import memory
from rodless_control import Law, Measurement, PidParameters, ReferencePoint, references
from rodless_control.references import Reference
from rodless_lab import closed_loop, ensemble, linearise
from rodless_lab.simulation.closed_loop import AnyLaw, Loop
from rodless_sim import Rig, RigParameters, Trace, simulate

HOLD = references.constant(0.01)


def hold(_measurement: Measurement, _reference: ReferencePoint) -> float:
    """Hold the valve closed, in Python."""
    return 5.08


class Point:
    """A reference that is a function of time."""

    def __init__(self, sample: Callable[[float], object]) -> None:
        self.sample = sample


class Points(Point):
    """A reference that gives all its points at once."""

    def __init__(self, samples: Callable[[np.ndarray], object]) -> None:
        super().__init__(lambda _: (0.0, 0.0))
        self.samples = samples


def run(law: AnyLaw, reference: object, duration: object = 0.005, period: object = 1e-3) -> object:
    """Six samples."""
    return closed_loop(RigParameters(), law, reference, duration, period)  # type: ignore[arg-type]


@pytest.mark.parametrize("law", [PidParameters(), hold], ids=["compiled", "python"])
@pytest.mark.parametrize(
    "answer",
    [
        (0.01,),
        (0.01, 0.0, 0.0),
        (math.nan, 0.0),
        (0.01, math.inf),
        (None, 0.0),
        ("1", "2"),
        (10**400, 0.0),
        1,
        None,
    ],
    ids=str,
)
def test_a_reference_that_answers_no_point_is_named_with_the_time(
    law: AnyLaw, answer: object
) -> None:
    """One line names reference, time, answer and what it must be; the law is not blamed."""
    reference = Point(lambda time: (0.01, 0.0) if time < 0.003 else answer)
    with pytest.raises(ValueError, match=r"^at 0\.003 s: reference Point answered ") as refusal:
        run(law, reference)
    assert "must be two finite numbers: position (m) and velocity (m/s)" in str(refusal.value)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    "answer",
    [
        lambda times: np.zeros((len(times), 1)),
        lambda times: np.zeros((len(times) - 1, 2)),
        lambda times: np.full((len(times), 2), "1"),
        lambda _: [[1.0], [2.0, 3.0]],
        lambda _: None,
    ],
)
def test_points_of_another_shape_are_refused(answer: Callable[[np.ndarray], object]) -> None:
    """The compiled loop would read past their end."""
    with pytest.raises(ValueError, match=r"^reference Points: samples\(times\) answered"):
        run(PidParameters(), Points(answer))
    with pytest.raises(ValueError, match=r"^at 0\.002 s: reference Points answered \(nan, 0\.0\)"):
        run(PidParameters(), Points(lambda _: np.array([[0.01, 0.0]] * 2 + [[math.nan, 0.0]] * 4)))


@pytest.mark.parametrize("reference", [None, 5, "step"])
def test_what_is_no_reference_is_refused(reference: object) -> None:
    """The text says what to give."""
    with pytest.raises(TypeError, match=r"is no reference: give one of rodless_control.references"):
        run(PidParameters(), reference)


def test_a_reference_in_millimetres_is_refused() -> None:
    """58 m is farther than any rig; the time and the way out are named, and nothing has run."""
    with pytest.raises(
        ValueError, match=r"^at 0.002 s: the reference asks for 58 m, must be"
    ) as no:
        run(PidParameters(), references.step(0.0, 58.0, at=0.002))
    assert str(no.value).endswith("positions are in m")
    run(PidParameters(), references.step(0.0, 10.0, at=0.002))


def test_whole_numbers_make_points() -> None:
    """A reference of ints is that of the same floats, at once and point by point."""
    for reference in (
        Point(lambda _: (0, 0)),
        Points(lambda times: np.zeros((len(times), 2), dtype=np.int64)),
    ):
        found: Reference = reference  # type: ignore[assignment]
        assert np.array_equal(references.sampled(found, np.arange(3.0)), np.zeros((3, 2)))
        assert references.sampled(found, np.arange(3.0)).dtype == np.float64


def test_a_run_longer_than_the_memory_is_refused_with_its_size() -> None:
    """Before a byte of it is taken."""
    endless = np.broadcast_to(5.5, 10**11)
    with pytest.raises(ValueError, match=r"^100000000000 voltages refused: .* GB of memory"):
        simulate(RigParameters(), endless, 1e-3)
    with pytest.raises(ValueError, match=r"^duration 1e\+09 s .* take .* GB of memory") as refusal:
        run(PidParameters(), HOLD, 1e9)
    assert "shorten it, or lengthen the period" in str(refusal.value)


def test_the_size_of_a_run_is_what_it_takes(monkeypatch: pytest.MonkeyPatch) -> None:
    """It runs where there is that much, and is refused where there is less than its result."""
    result = 501 * 8 * 16
    monkeypatch.setattr(memory, "available_memory", lambda: result)
    with pytest.raises(ValueError, match=r"501 samples take "):
        run(PidParameters(), HOLD, 0.5)
    monkeypatch.setattr(memory, "available_memory", lambda: 5 * result)
    run(PidParameters(), HOLD, 0.5)


@pytest.mark.parametrize(("free", "runs"), [(3, 3), (100, 8), (0, 1)])
def test_no_more_runs_at_once_than_there_is_memory_for(
    monkeypatch: pytest.MonkeyPatch, free: int, runs: int
) -> None:
    """Of eight threads an ensemble takes as many as their runs have room, and one in any case."""
    size = Loop(PidParameters(), HOLD, 0.5, 1e-3).size
    taken: list[int] = []

    def note(_work: object, _rigs: object, workers: int) -> list[object]:
        taken.append(workers)
        return []

    monkeypatch.setattr("rodless_lab.simulation.ensemble.in_order", note)
    monkeypatch.setattr("rodless_lab.simulation.closed_loop.room_for", lambda _size: free)
    ensemble([RigParameters()], PidParameters(), HOLD, 0.5, workers=8)
    monkeypatch.undo()
    monkeypatch.setattr(memory, "available_memory", lambda: free * size + size // 2)
    assert taken == [runs]
    assert memory.room_for(size) == free


def test_what_a_group_has_taken_is_not_free(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Of a container's 1000 bytes 700 are in use, 150 of them copies of files: 450 are free."""
    monkeypatch.setattr(memory, "GROUP", tmp_path)
    assert memory.available_memory() > 10**6
    written = {
        "memory.max": "1000\n",
        "memory.current": "700\n",
        "memory.stat": "anon 500\nfile 150\ninactive_file 100\nactive_file 50\n",
    }
    for name, text in written.items():
        (tmp_path / name).write_text(text, encoding="ascii")
    assert memory.available_memory() == 450
    (tmp_path / "memory.stat").unlink()
    assert memory.available_memory() == 1000
    (tmp_path / "memory.max").write_text("max\n", encoding="ascii")
    assert memory.available_memory() > 10**6


@pytest.mark.parametrize("bad", [-1.0, 0.0, math.nan, 1e300])
def test_a_bad_time_is_refused_by_its_own_name(bad: float) -> None:
    """A period is called a period."""
    with pytest.raises(ValueError, match=r"^period .* refused"):
        run(PidParameters(), HOLD, 1.0, bad)
    with pytest.raises(ValueError, match=r"^duration .* refused"):
        run(PidParameters(), HOLD, bad)


def test_what_are_no_rig_parameters_are_refused() -> None:
    """By name, before anything runs."""
    with pytest.raises(TypeError, match="no RigParameters: give RigParameters"):
        closed_loop({}, hold, HOLD, 0.005, 1e-3)  # type: ignore[arg-type]


def test_terms_of_a_law_that_cannot_be_columns_are_refused() -> None:
    """A text would be taken letter by letter."""

    class Odd(Law):
        TERMS = "force"  # type: ignore[assignment]

        def update(self, *_: object) -> float:
            return 5.08

    with pytest.raises(TypeError, match=r"^Odd: its TERMS 'force' must be identifiers"):
        run(Odd(), HOLD)


def test_a_run_can_be_pickled_and_copied() -> None:
    """To the last bit, with its terms; all of it stays read-only."""
    given = closed_loop(RigParameters(), PidParameters(), HOLD, 0.05, 1e-3)
    for found in (pickle.loads(pickle.dumps(given)), copy.copy(given), copy.deepcopy(given)):
        assert type(found) is type(given)
        assert found.units() == given.units()
        assert list(found.terms) == list(given.terms)
        for name, values in given.columns().items():
            assert np.array_equal(found.columns()[name], values), name
        with pytest.raises(TypeError):
            found.terms["p"] = given.position
        for values in (*found.columns().values(), *found.terms.values(), found.true_position):
            assert not values.flags.writeable


@pytest.mark.parametrize(
    "again", [copy.copy, copy.deepcopy, lambda it: pickle.loads(pickle.dumps(it))]
)
def test_what_was_computed_cannot_be_written(again: Callable[[Any], Any]) -> None:
    """Neither a trace nor a linear model, nor their copies."""
    run = again(simulate(RigParameters(), [6.0] * 3, 1e-3))
    for name, values in run.columns().items():
        with pytest.raises(ValueError, match="read-only"):
            values[0] = 0.0
        with pytest.raises(AttributeError, match="cannot be changed"):
            setattr(run, name, values)
    given = linearise(RigParameters(), position=0.1, voltage=6.0)
    model = again(given)
    for name in ("A", "B", "C", "D"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(model, name)[0, 0] = 1.0
    assert np.array_equal(model.poles, given.poles)


@pytest.mark.parametrize(
    "take",
    [
        lambda step: simulate(RigParameters(), [5.0, 5.0], step),
        lambda step: closed_loop(RigParameters(), PidParameters(), HOLD, 4.0 * step, step),
        lambda step: Rig(RigParameters()).advance(5.0, step),
    ],
    ids=["simulate", "closed_loop", "advance"],
)
def test_one_step_lasts_an_hour_at_most(take: Callable[[float], object]) -> None:
    """It is one compiled call, which hears no Ctrl-C; several steps are refused for memory only."""
    for step in (3601.0, 1e9):
        with pytest.raises(ValueError, match=r" s refused: one step lasts at most 3600 s; take"):
            take(step)
    closed = simulate(RigParameters({"cylinder.locked": True}), [5.08], 3600.0)
    assert closed.time[-1] == 3600.0


@pytest.mark.parametrize("small", ["velocity", "acceleration", "jerk"])
def test_a_move_with_limits_too_small_for_a_float_is_refused(small: str) -> None:
    """It would divide by zero, or be at its target at once."""
    limits = {"velocity": 0.5, "acceleration": 5.0, "jerk": 100.0, small: 5e-324}
    with pytest.raises(ValueError, match=r"no move over 0\.1 m can be computed"):
        references.move(0.0, 0.1, **limits)
    with pytest.raises(TypeError, match=f"^{small} 'x' refused: must be a number"):
        references.move(0.0, 0.1, **{**limits, small: "x"})  # type: ignore[arg-type]


@pytest.mark.parametrize(("duration", "period"), [(1e-3, 6.0), (1e-9, 2e-9)])
def test_a_run_shorter_than_one_period_is_refused(duration: float, period: float) -> None:
    """Duration and period were swapped, most likely; the text has both."""
    with pytest.raises(ValueError, match=rf"^duration {duration:g} s refused.*{period:g} s"):
        run(PidParameters(), HOLD, duration, period)


def test_a_duration_that_is_no_multiple_of_the_period_is_rounded() -> None:
    """To the nearest, 2.5 periods to 2."""
    counts = [len(run(hold, HOLD, duration).time) for duration in (0.0024, 0.0025, 0.0026)]  # type: ignore[attr-defined]
    assert counts == [3, 3, 4]


@pytest.mark.parametrize(
    "values", [(0.1, 1e308, 1e308), (0.1, 0.01, 1e300), (1e308, 1e308, 1.0), (0, 10**308, 1.0)]
)
def test_a_sine_that_cannot_be_computed_is_refused(values: tuple[float, ...]) -> None:
    """Where it is made, and not with Python's words where it is sampled."""
    with pytest.raises(ValueError, match=r"refused: too large for a sine") as refusal:
        references.sine(*values)
    assert len(str(refusal.value)) < 400


def test_the_arrays_of_a_run_cannot_be_written() -> None:
    """Neither its columns nor its terms; what was given to make a trace can be, as before."""
    found = closed_loop(RigParameters(), PidParameters(), HOLD, 0.005, 1e-3)
    for values in (*found.columns().values(), *found.terms.values()):
        with pytest.raises(ValueError, match="read-only"):
            values[0] = 1.0
    given = {name: np.zeros(2) for name in simulate(RigParameters(), [5.0], 1e-3).columns()}
    Trace(**given)
    given["position"][0] = 1.0
