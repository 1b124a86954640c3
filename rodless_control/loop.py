# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What happens at one sample: the reference, the law, and what makes it safe."""

import math
from collections.abc import Callable
from typing import NamedTuple, TypeVar

from rodless_base.constants import SECONDS_PER_NANOSECOND
from rodless_base.measurement import Measurement
from rodless_base.one_line import described, traced
from rodless_control.controller import LawError, checked_answer, law_name, output_limits
from rodless_control.controller_parameters import ControllerParameters
from rodless_control.law_calls import LawCalls
from rodless_control.laws import make_law
from rodless_control.setpoint import SetpointFollower

Result = TypeVar("Result")


class Output(NamedTuple):
    """The answer to one sample."""

    reference: float  # m
    voltage: float  # V, within the limits
    terms: dict[str, float]  # the law's TERMS, in units of its own


class ControlLoop:
    """One command per sample; time is the samples' own, in ns.

    The counters only grow, so that a fault stays visible after the loop has recovered. A law that
    fails is not called again: :meth:`reset` makes it anew, with the parameters last given.
    """

    def __init__(self, parameters: ControllerParameters) -> None:
        """Wait for the first sample; raises ParameterError where the law cannot be made."""
        self.setpoints = SetpointFollower(parameters)
        self._given = parameters.of_law()
        self.law = make_law(parameters.LAW_CLASS, self._given)
        self.not_finite = self.lost = self.restarts = self.failures = 0
        self.failure: str | None = None
        self._limits = output_limits(self._given)
        self._last: int | None = None
        self._answered: tuple[Measurement, Output] | None = None
        self._attempt(self.law.reset)

    def configure(self, parameters: ControllerParameters) -> None:
        """Change the parameters, without a jump in the command where the law can."""
        self.setpoints.configure(parameters)
        self._given = parameters.of_law()
        self._limits = output_limits(self._given)
        if self.failure is None:
            self._attempt(lambda: self.law.configure(self._given))

    def change_law(self, parameters: ControllerParameters) -> None:
        """Go on with the law of ``parameters`` as after :meth:`reset`.

        Raises ParameterError where the law cannot be made; then everything is as it was.
        """
        given = parameters.of_law()
        self.law = make_law(parameters.LAW_CLASS, given)
        self.failure, self._given, self._limits = None, given, output_limits(given)
        self.setpoints.configure(parameters)
        self.reset()

    def reset(self) -> None:
        """Forget the run so far: a failure too, and the set-point, so that nothing moves."""
        self.setpoints.forget()
        if self.failure is not None:
            self.failure = None
            # What a law keeps that has failed cannot be trusted, its parameters included.
            self._attempt(self._make_law_anew)
        # Offered again, a sample keeps its answer, but for one that may be of a new run.
        if self._last == 0:
            self._answered = None
        self._start_anew()

    def _make_law_anew(self) -> None:
        self.law = make_law(type(self.law), self._given)

    def _start_anew(self) -> None:
        self.setpoints.reset()
        if self.failure is None:
            self._attempt(self.law.reset)
        self._last = None

    def hold(self) -> None:
        """Count that samples are missing, and tell the law so."""
        self.lost += 1
        self.expect_gap()

    def leave_out(self, stamp: int) -> None:
        """Take note of a sample (ns) that gets no answer: it may be of a new run all the same."""
        self._notice_restart(stamp)

    def _notice_restart(self, stamp: int) -> None:
        if self._last is not None and stamp < self._last:
            self.restarts += 1
            self._answered = None
            self._start_anew()

    def expect_gap(self) -> None:
        """Tell the law that the next sample comes after a gap."""
        self._answered = None
        if self.failure is None:
            self._attempt(self.law.hold)

    def sample(self, measurement: Measurement) -> Output | None:
        """Return the command for a sample, or None to stay safe.

        None means that something the law uses is not finite, and then the law holds; or that the
        law has failed. Time that runs backwards means that the plant was reset, and so is the
        loop. A sample whose time stands still is answered without integrating.
        """
        self._notice_restart(measurement.stamp)
        if not all(map(math.isfinite, self._used(measurement))):
            self.not_finite += 1
            self.expect_gap()
            return None
        last = measurement.stamp if self._last is None else self._last
        interval = (measurement.stamp - last) * SECONDS_PER_NANOSECOND
        self._last = measurement.stamp
        output = self._answer(measurement, interval)
        self._answered = None if output is None else (measurement, output)
        return output

    def repeat(self, measurement: Measurement) -> Output | None:
        """Return what the last sample was answered by if this is that one again, or else None.

        The law does not hear of it: what it keeps would depend on how often a sample is offered.
        One that reads pressures may have taken its place meanwhile.
        """
        if self._answered is None:
            return None
        sample, output = self._answered
        same = (sample.stamp, sample.position) == (measurement.stamp, measurement.position)
        return output if same else None

    def _used(self, measurement: Measurement) -> tuple[float, ...]:
        _, position, *pressures = measurement
        return (position, *pressures) if self.law.USES_PRESSURES else (position,)

    def _answer(self, measurement: Measurement, interval: float) -> Output | None:
        time = measurement.stamp * SECONDS_PER_NANOSECOND
        reference = self.setpoints.sample(time, measurement.position)
        if self.failure is not None:
            return None
        numbers = self._attempt(
            lambda: checked_answer(self.law, self.law.update(measurement, reference, interval))
        )
        if numbers is None:
            return None
        low, high = self._limits
        voltage, *terms = numbers
        return Output(
            reference.position,
            min(max(voltage, low), high),
            dict(zip(self.law.TERMS, terms, strict=True)),
        )

    def _attempt(self, action: Callable[[], Result]) -> Result | None:
        """Let the law act; whatever it raises is its failure and not the node's end."""
        try:
            LawCalls.under_way = True
            return action()
        except LawError as error:
            self._fail(described(error))
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            self._fail(f"{law_name(self.law)} failed: {traced(error)}")
        finally:
            LawCalls.under_way = False
        return None

    def _fail(self, failure: str) -> None:
        self.failures += 1
        self.stop(failure)

    def stop(self, reason: str) -> None:
        """Answer no sample any more until :meth:`reset`."""
        self.failure = reason
        self._answered = None
