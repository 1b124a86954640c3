# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Each term of the control law against numbers worked out by hand."""

from collections.abc import Callable

import numpy as np
import pytest

from rodless_control import Measurement, Pid, PidParameters, ReferencePoint

Make = Callable[..., PidParameters]


def test_proportional_term(bare: Make) -> None:
    """10 V/m on an error of 0.12 - 0.02 = 0.1 m is 1 V, on top of the neutral 5 V."""
    command = Pid(bare(kp=10.0)).update(Measurement(0, 0.02), ReferencePoint(0.12), 0.0)
    assert command.error == pytest.approx(0.1, rel=1e-15)
    assert command.p == pytest.approx(1.0, rel=1e-15)
    assert command.voltage == pytest.approx(6.0, rel=1e-15)
    assert (command.i, command.d, command.feedforward) == (0.0, 0.0, 0.0)


def test_integral_term_grows_by_gain_error_and_time(bare: Make) -> None:
    """2 V/(m·s) on 0.1 m for 0.5 s adds 0.1 V a sample; the first sample adds nothing."""
    pid = Pid(bare(ki=2.0))
    terms = [pid.update(Measurement(0, 0.0), ReferencePoint(0.1), 0.5).i for _ in range(4)]
    assert terms == pytest.approx([0.0, 0.1, 0.2, 0.3], abs=1e-15)


def test_integral_term_is_the_sum_of_errors_times_intervals(bare: Make) -> None:
    """With uneven errors and intervals it is ki times their scalar product."""
    generator = np.random.default_rng(1)
    errors, intervals = generator.uniform(-0.1, 0.1, 50), generator.uniform(1e-4, 0.01, 50)
    pid = Pid(bare(ki=7.0))
    pid.update(Measurement(0, 0.0), ReferencePoint(0.0), 0.0)
    for error, interval in zip(errors, intervals, strict=True):
        command = pid.update(Measurement(0, 0.0), ReferencePoint(error), interval)
    assert command.i == pytest.approx(7.0 * errors @ intervals, rel=1e-12)
    assert command.voltage == pytest.approx(5.0 + command.i, rel=1e-15)


def test_derivative_term(bare: Make) -> None:
    """A filter that closes half of the gap in 0.1 s sees 0.04 m of 0.08 m: 0.4 m/s, -1.6 V."""
    pid = Pid(bare(kd=4.0, filter_bandwidth=np.log(2.0) / 0.1))
    pid.update(Measurement(0, 0.0), ReferencePoint(0.0), 0.0)
    command = pid.update(Measurement(0, 0.08), ReferencePoint(0.0), 0.1)
    assert command.d == pytest.approx(-1.6, rel=1e-13)
    assert command.voltage == pytest.approx(3.4, rel=1e-13)


def test_feedforward_term(bare: Make) -> None:
    """3 V·s/m on a reference moving at -0.2 m/s is -0.6 V, whatever the error."""
    command = Pid(bare(feedforward=3.0)).update(Measurement(0, 0.1), ReferencePoint(0.4, -0.2), 0.0)
    assert command.feedforward == pytest.approx(-0.6, rel=1e-15)
    assert command.voltage == pytest.approx(4.4, rel=1e-15)


def test_terms_add_up(bare: Make) -> None:
    """With all terms at work the voltage is the neutral one plus their sum."""
    pid = Pid(bare(kp=9.0, ki=5.0, kd=2.0, feedforward=1.5))
    pid.update(Measurement(0, 0.0), ReferencePoint(0.1, 0.1), 0.0)
    command = pid.update(Measurement(0, 0.02), ReferencePoint(0.11, 0.1), 0.01)
    terms = (command.p, command.i, command.d, command.feedforward)
    assert all(terms)
    assert command.voltage == pytest.approx(5.0 + sum(terms), rel=1e-14)


def test_integers_are_taken_for_reals(bare: Make) -> None:
    """Positions and times given as integers give what the same reals give."""
    whole, real = Pid(bare(kp=1.0, ki=1.0, kd=1.0)), Pid(bare(kp=1.0, ki=1.0, kd=1.0))
    whole.update(Measurement(0, 0), ReferencePoint(0, 0), 0)
    real.update(Measurement(0, 0.0), ReferencePoint(0.0), 0.0)
    assert whole.update(Measurement(0, 1), ReferencePoint(2, 0), 1) == real.update(
        Measurement(0, 1.0), ReferencePoint(2.0), 1.0
    )


def test_reset_makes_the_next_sample_the_first(bare: Make) -> None:
    """After a reset a used controller answers like a new one, sample for sample."""
    parameters = bare(kp=3.0, ki=5.0, kd=2.0)
    used, new = Pid(parameters), Pid(parameters)
    for k in range(20):
        used.update(Measurement(0, 0.01 * k), ReferencePoint(0.1), 0.01)
    used.hold()
    used.reset()
    samples = [(Measurement(0, x), ReferencePoint(0.2), 0.01) for x in (0.05, 0.06, 0.08)]
    assert [used.update(*s) for s in samples] == [new.update(*s) for s in samples]
