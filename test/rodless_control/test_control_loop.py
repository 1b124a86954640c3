# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""One position sample after the other: time, faults and what survives them."""

import math
import re
from typing import NamedTuple

import pytest

from rodless_control import ControllerParameters, Law, Measurement, Pid, ReferencePoint
from rodless_control.law_calls import LawCalls
from rodless_control.loop import ControlLoop

MILLISECOND = 1_000_000
NOT_FINITE = (math.nan, math.inf, -math.inf)


def charged(**values: object) -> tuple[ControlLoop, int, float]:
    """A loop whose integrator has worked for 50 ms, its time (ns) and its integral term."""
    loop = ControlLoop(ControllerParameters({f"reference.{k}": v for k, v in values.items()}))
    loop.setpoints.receive(0.051)
    for k in range(51):
        output = loop.sample(Measurement(k * MILLISECOND, 0.05))
    assert output is not None
    assert output.terms["i"] == pytest.approx(55.0 * 1e-3 * 50e-3, rel=1e-9)
    return loop, 50 * MILLISECOND, output.terms["i"]


def test_it_runs_the_law_on_the_reference_in_force() -> None:
    """Samples at uneven times give what Pid gives for that reference and those intervals."""
    values = {"reference.type": "sine", "reference.at": 0.0, "reference.centre": 0.05}
    parameters = ControllerParameters(values)
    loop, pid, last = ControlLoop(parameters), Pid(parameters.of_law()), 0
    for k in range(200):
        time = MILLISECOND * (k * k // 7)
        position = 0.05 + 0.001 * math.cos(k)
        angle = 2.0 * math.pi * 0.381 * time * 1e-9
        reference = 0.05 + 0.02 * math.sin(angle)
        velocity = 0.02 * 2.0 * math.pi * 0.381 * math.cos(angle)
        output = loop.sample(Measurement(time, position))
        expected = pid.update(
            Measurement(0, position), ReferencePoint(reference, velocity), (time - last) * 1e-9
        )
        last = time
        assert output is not None
        assert output.reference == pytest.approx(reference, rel=1e-12)
        assert [output.voltage, *output.terms.values()] == pytest.approx(
            list(expected), rel=1e-9, abs=1e-12
        )


def test_time_that_stands_still_integrates_nothing() -> None:
    """A second sample at the same time is answered with the same integral and velocity."""
    loop, now, integral = charged()
    loop.sample(Measurement(now + MILLISECOND, 0.0501))
    again = [loop.sample(Measurement(now + MILLISECOND, 0.0501)) for _ in range(20)]
    assert again[0] is not None
    assert again == [again[0]] * 20
    assert again[0].terms["i"] > integral
    assert loop.restarts == 0


def test_a_sample_that_is_offered_again_is_answered_by_what_it_was() -> None:
    """Until the loop has something else to answer by; another sample of its time is a new one."""
    loop, now, _ = charged()
    last = Measurement(now + MILLISECOND, 0.0501)
    assert loop.repeat(last) is None
    answer = loop.sample(last)
    assert answer is not None
    assert loop.repeat(last) is answer
    assert loop.repeat(last._replace(position=0.0502)) is None
    loop.hold()
    assert loop.repeat(last) is None
    loop.sample(last)
    loop.sample(last._replace(position=math.nan))
    assert loop.repeat(last) is None
    loop.sample(last)
    loop.stop("enough")
    assert loop.repeat(last) is None


@pytest.mark.parametrize("begin", ["reset", "another law"])
@pytest.mark.parametrize("stamp", [0, MILLISECOND])
def test_what_begins_anew_answers_no_sample_anew(begin: str, stamp: int) -> None:
    """Nor does it take part in a sample that it has no command for; sample 0 may be a new run's."""
    loop = ControlLoop(ControllerParameters())
    last = Measurement(stamp, 0.0501)
    answer = loop.sample(last)
    if begin == "reset":
        loop.reset()
    else:
        loop.change_law(ControllerParameters.for_law("state_feedback")())
    again = Measurement(stamp, 0.0501, 4e5, 4e5, 6e5)
    assert loop.repeat(again) is (answer if stamp else None)
    following = loop.sample(Measurement(stamp + MILLISECOND, 0.06, 4e5, 4e5, 6e5))
    assert following is not None
    assert following.reference == 0.06


def test_a_law_that_fails_as_it_begins_anew_answers_no_sample_again() -> None:
    """Not by what it said before, either: the valve is to be closed."""
    loop, now, _ = charged()
    last = Measurement(now + MILLISECOND, 0.0501)
    assert loop.sample(last) is not None

    def fail() -> None:
        raise RuntimeError("no reset")

    loop.law.reset = fail  # type: ignore[method-assign]
    loop.reset()
    assert "no reset" in str(loop.failure)
    assert loop.repeat(last) is None


def test_new_gains_answer_no_sample_anew() -> None:
    """In lock-step it would depend on how often a sample is offered by which its command is."""
    loop, now, _ = charged()
    last = Measurement(now + MILLISECOND, 0.0501)
    answer = loop.sample(last)
    assert answer is not None
    loop.configure(ControllerParameters({"controller.kp": 1600.0}))
    assert loop.repeat(last) is answer
    following = loop.sample(Measurement(now + 2 * MILLISECOND, 0.0502))
    assert following is not None
    assert following.terms["p"] == pytest.approx(1600.0 * (following.reference - 0.0502))


def test_time_that_runs_backwards_starts_the_loop_anew() -> None:
    """A plant set back to zero: no integral, no velocity, the set-point still in force."""
    loop, now, _ = charged()
    loop.sample(Measurement(now + MILLISECOND, 0.06))
    output = loop.sample(Measurement(0, 0.02))
    assert output is not None
    assert (output.terms["i"], output.terms["d"]) == (0.0, 0.0)
    assert output.reference == 0.051
    assert loop.restarts == 1
    after = loop.sample(Measurement(MILLISECOND, 0.0505))
    assert after is not None
    assert after.terms["i"] == pytest.approx(55.0 * 5e-4 * 1e-3, rel=1e-9)
    assert loop.restarts == 1


@pytest.mark.parametrize("position", NOT_FINITE)
def test_a_position_that_is_not_finite_gives_none_and_keeps_the_integral(position: float) -> None:
    """The caller is told to stay safe; the next good sample goes on with the integral."""
    loop, now, integral = charged()
    for k in range(1, 6):
        assert loop.sample(Measurement(now + k * MILLISECOND, position)) is None
    assert loop.not_finite == 5
    output = loop.sample(Measurement(now + 6 * MILLISECOND, 0.045))
    assert output is not None
    assert output.terms["i"] == integral
    assert output.terms["d"] == 0.0
    later = loop.sample(Measurement(now + 7 * MILLISECOND, 0.0505))
    assert later is not None
    assert later.terms["i"] == pytest.approx(integral + 55.0 * 5e-4 * 1e-3, rel=1e-9)
    assert loop.not_finite == 5


def test_a_plant_that_is_reset_while_its_sensor_is_gone_starts_the_loop_anew() -> None:
    """The sensor is back only once plant time has passed where the old run was."""
    loop, now, _ = charged()
    for k in range(3):
        assert loop.sample(Measurement(k * MILLISECOND, math.nan)) is None
    assert (loop.restarts, loop.not_finite) == (1, 3)
    output = loop.sample(Measurement(2 * now, 0.02))
    assert output is not None
    assert (output.terms["i"], output.terms["d"], output.reference) == (0.0, 0.0, 0.051)


@pytest.mark.parametrize("position", NOT_FINITE)
def test_the_first_position_may_be_missing(position: float) -> None:
    """Without any good sample there is no command; the first good one is where it holds."""
    loop = ControlLoop(ControllerParameters())
    assert loop.sample(Measurement(0, position)) is None
    output = loop.sample(Measurement(MILLISECOND, 0.03))
    assert output is not None
    assert (output.reference, output.voltage) == (0.03, 5.08)


def test_missing_positions_keep_the_integral() -> None:
    """hold() over a gap of 10 s: the integral stays, the way moved meanwhile is no velocity."""
    loop, now, integral = charged()
    loop.hold()
    output = loop.sample(Measurement(now + 10_000 * MILLISECOND, 0.0503))
    assert output is not None
    assert (output.terms["i"], output.terms["d"]) == (integral, 0.0)
    assert loop.lost == 1


@pytest.mark.parametrize("kind", ["ramp", "move"])
def test_a_restart_behind_a_gap_is_noticed(kind: str) -> None:
    """A plant that went away and came back at time zero is still moved to its set-points."""
    loop = ControlLoop(ControllerParameters({"reference.type": kind}))
    start = 100_000 * MILLISECOND
    loop.sample(Measurement(start, 0.0))
    loop.setpoints.receive(0.05)
    for k in range(1500):
        loop.sample(Measurement(start + k * MILLISECOND, 0.0))
    loop.hold()
    loop.sample(Measurement(0, 0.0))
    assert loop.restarts == 1
    loop.setpoints.receive(0.02)
    outputs = [loop.sample(Measurement(k * MILLISECOND, 0.0)) for k in range(1, 4000)]
    assert outputs[-1] is not None
    assert outputs[-1].reference == 0.02


def test_reset_forgets_all_and_holds_the_carriage_where_it_is() -> None:
    """A reset by hand forgets integral, velocity and set-point, and is no fault to be counted."""
    loop, now, _ = charged()
    loop.reset()
    output = loop.sample(Measurement(now + MILLISECOND, 0.02))
    assert output is not None
    assert (output.terms["i"], output.terms["d"], output.reference) == (0.0, 0.0, 0.02)
    assert (loop.restarts, loop.lost, loop.not_finite) == (0, 0, 0)


def test_changed_parameters_reach_law_and_reference() -> None:
    """New gains and a new reference act from the next sample on."""
    loop, now, _ = charged()
    values = {"controller.kp": 100.0, "reference.type": "step", "reference.target": 0.08}
    loop.configure(ControllerParameters({**values, "reference.at": 0.0}))
    output = loop.sample(Measurement(now + MILLISECOND, 0.05))
    assert output is not None
    assert output.reference == 0.08
    assert output.terms["p"] == pytest.approx(100.0 * 0.03, rel=1e-12)


@pytest.mark.parametrize("position", [1e308, -1e308])
def test_a_wild_position_is_answered_within_the_limits(position: float) -> None:
    """A finite position is used however far it is; afterwards the loop finds its way back."""
    loop, now, _ = charged()
    output = loop.sample(Measurement(now + MILLISECOND, position))
    assert output is not None
    assert output.voltage == (0.0 if position > 0.0 else 10.0)
    for k in range(2, 3000):
        output = loop.sample(Measurement(now + k * MILLISECOND, 0.051))
    assert output is not None
    assert output.terms["d"] == pytest.approx(0.0, abs=1e-9)


class Looking(Law):
    """Notes whether it could be broken off."""

    USES_PRESSURES = False

    def update(
        self,
        measurement: Measurement,  # noqa: ARG002
        reference: ReferencePoint,  # noqa: ARG002
        interval: float,  # noqa: ARG002
    ) -> float:
        """Look."""
        self.seen = LawCalls.under_way
        return 5.0


def test_a_law_can_be_broken_off_while_it_is_asked_and_nothing_else_can() -> None:
    """A request to stop ends a law that does not return, not what comes after it."""
    loop = ControlLoop(ControllerParameters())
    loop.law = law = Looking({})
    assert loop.sample(Measurement(0, 0.05)) is not None
    assert law.seen
    assert not LawCalls.under_way


class Moody(Law):
    """A law that does what it is told to: answer, or fail."""

    TERMS = ("mood",)

    class Answer(NamedTuple):
        """A voltage and a term."""

        voltage: float
        mood: float

    def reset(self) -> None:
        """Be well again."""
        self.answer: object = self.Answer(6.0, 1.0)

    def hold(self) -> None:
        """Fail where that is asked for."""
        if self.answer == "hold":
            raise RuntimeError("no hold")

    def update(self, *_: object) -> object:
        """Answer."""
        if isinstance(self.answer, Exception):
            raise self.answer
        return self.answer


def moody_parameters(values: dict[str, object] | None = None) -> ControllerParameters:
    """Return a node's set with a moody law."""
    return type("Set", (ControllerParameters,), {"LAW_CLASS": Moody})(values)


@pytest.fixture
def moody() -> ControlLoop:
    """Return a loop around a moody law that has answered one sample."""
    loop = ControlLoop(moody_parameters({"controller.maximum_voltage": 5.5}))
    output = loop.sample(Measurement(0, 0.05, 1e5, 1e5, 6e5))
    assert output is not None
    assert (output.reference, output.voltage, output.terms) == (0.05, 5.5, {"mood": 1.0})
    return loop


@pytest.mark.parametrize(
    ("answer", "complaint"),
    [
        (KeyError("x"), r"law Moody failed: KeyError: 'x' \(test_control_loop.py, line \d+\)"),
        (RuntimeError("two\nlines"), r"law Moody failed: RuntimeError: two lines \(.*\)"),
        (None, "law Moody answered None: must be voltage and mood"),
        (5.0, r"law Moody answered 5\.0: must be voltage and mood"),
        (Moody.Answer(math.nan, 1.0), "law Moody answered nan V: must be a finite number"),
        (
            Moody.Answer(True, 1.0),
            r"law Moody answered Answer\(voltage=True, mood=1\.0\): must be numbers",
        ),
    ],
)
def test_a_law_that_fails_is_not_asked_again_until_reset(
    moody: ControlLoop, answer: object, complaint: str
) -> None:
    """No command comes of it; the text names law and error in one line; a reset heals it."""
    moody.law.answer = answer  # type: ignore[attr-defined]
    for k in range(1, 4):
        assert moody.sample(Measurement(k * MILLISECOND, 0.05, 1e5, 1e5, 6e5)) is None
    assert re.fullmatch(complaint, moody.failure or "")
    assert moody.failures == 1
    moody.sample(Measurement(0, 0.05, 1e5, 1e5, 6e5))
    assert moody.failure is not None, "a reset of the plant is none of the controller"
    moody.reset()
    assert moody.failure is None
    output = moody.sample(Measurement(MILLISECOND, 0.05, 1e5, 1e5, 6e5))
    assert output is not None
    assert moody.failures == 1


def test_a_law_may_fail_wherever_it_is_asked(moody: ControlLoop) -> None:
    """hold() and configure() of a user are no more trusted than update()."""
    moody.law.answer = "hold"  # type: ignore[attr-defined]
    moody.hold()
    place = r"\(test_control_loop\.py, line \d+\)"
    assert re.fullmatch(rf"law Moody failed: RuntimeError: no hold {place}", moody.failure or "")
    moody.reset()
    moody.law.configure = None  # type: ignore[assignment,method-assign]
    moody.configure(moody_parameters())
    assert moody.failures == 2
    assert "TypeError" in (moody.failure or "")


@pytest.mark.parametrize("already_failed", [False, True])
def test_parameters_in_force_are_those_last_given_even_where_the_law_refused_them(
    moody: ControlLoop, already_failed: bool
) -> None:
    """After a failure, in configure() or before it, a reset makes the law with the new limits."""
    if already_failed:
        moody.law.answer = RuntimeError()  # type: ignore[attr-defined]
        assert moody.sample(Measurement(0, 0.05, 1e5, 1e5, 6e5)) is None
    else:
        moody.law.configure = None  # type: ignore[assignment,method-assign]
    moody.configure(moody_parameters({"controller.maximum_voltage": 5.2}))
    assert moody.failures == 1
    failed = moody.law
    moody.reset()
    assert moody.law is not failed
    assert moody.law.parameters["controller.maximum_voltage"] == 5.2
    output = moody.sample(Measurement(0, 0.05, 1e5, 1e5, 6e5))
    assert output is not None
    assert output.voltage == 5.2


def test_a_law_that_cannot_be_made_anew_stays_failed(moody: ControlLoop) -> None:
    """Its failure says so, and it is not called."""
    moody.law.answer = RuntimeError()  # type: ignore[attr-defined]
    moody.sample(Measurement(0, 0.05, 1e5, 1e5, 6e5))
    failed = moody.law
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Moody, "__init__", None)
        moody.reset()
        assert moody.law is failed
        assert re.match(r"law Moody failed: ParameterError: .* refused: Moody", moody.failure or "")
        assert moody.sample(Measurement(0, 0.05, 1e5, 1e5, 6e5)) is None
    moody.reset()
    assert moody.sample(Measurement(0, 0.05, 1e5, 1e5, 6e5)) is not None


def test_a_pressure_that_is_not_finite_counts_where_the_law_uses_pressures(
    moody: ControlLoop,
) -> None:
    """A NaN among the pressures keeps a law that reads them from answering, and not the PID."""
    sample = Measurement(MILLISECOND, 0.05, 1e5, math.nan, 6e5)
    assert moody.sample(sample) is None
    assert (moody.not_finite, moody.failure) == (1, None)
    assert ControlLoop(ControllerParameters()).sample(sample) is not None
