# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The rig as a Gymnasium environment (extra ``gym``): readings in, a voltage out.

Observations are what the instruments read and what the carriage should do, in SI units and double
precision, so that a law that is driven through the environment answers with the bits of
``closed_loop``. For learning, scale them with gymnasium's wrappers (docs/gym.md).
"""

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from rodless_base.constants import MAXIMUM_VOLTAGE, MINIMUM_VOLTAGE, SECONDS_PER_NANOSECOND
from rodless_base.extras import missing_extra
from rodless_base.measurement import Measurement
from rodless_base.memory import refuse_more_than_there_is
from rodless_base.one_line import OneLineError, function_name, shown, traced
from rodless_control import references
from rodless_control.references import Reference, sampled
from rodless_lab.simulation.closed_loop import refuse_beyond_any_rig, sample_count
from rodless_lab.simulation.design import LARGEST_SEED
from rodless_lab.simulation.draw import draw
from rodless_sim import Rig, RigParameters, SimulationError
from rodless_sim.rig import applied_voltages
from rodless_sim.single_number import single_number
from rodless_sim.timing import nanoseconds, sample_times, step_nanoseconds

try:
    import gymnasium
    from gymnasium.error import ResetNeeded
    from gymnasium.spaces import Box
except ModuleNotFoundError as error:
    raise missing_extra("the Gymnasium environment", error.name, "gym") from error

Array = npt.NDArray[np.float64]

# No reference is faster, m/s.
FASTEST = 1e3

# What an observation holds, in this order, and bounds that none leaves; NaN is of a sensor that is
# gone.
OBSERVATION = (
    ("position", -1.0, 20.0),  # m, read
    ("pressure_a", -1e8, 1e8),  # Pa, read
    ("pressure_b", -1e8, 1e8),  # Pa, read
    ("supply_pressure", -1e8, 1e8),  # Pa, read
    ("reference", -20.0, 20.0),  # m
    ("reference_velocity", -FASTEST, FASTEST),  # m/s
)

# The reward of a sample: an error of 1 mm costs 1, a jump of the valve by 1 V costs a tenth.
ERROR = 1e-3  # m
JUMP = 10.0  # V

# What a motion costs that leaves what a rig can do, which ends the episode.
FAILURE = -1e3

# Numbers that an episode keeps of each sample: its time, and the reference's two with their copies.
NUMBERS_PER_SAMPLE = 8


def reward(error: float, jump: float) -> float:
    """Return the reward for an error (m) after the command has changed by ``jump`` (V)."""
    return -abs(error) / ERROR - abs(jump) / JUMP


class RigEnv(gymnasium.Env[Array, Array]):  # type: ignore[misc]  # no types where it is missing
    """One rig at a time, its law outside.

    Each episode has a rig of its own: ``rig`` with what ``ranges`` and ``factors`` draw, as
    :func:`rodless_lab.draw` takes them, and a ``sensors.seed``; all follow from the seed of
    :meth:`reset`.

    Parameters
    ----------
    rig
        The rig, by default the preset ``calibrated``.
    reference
        What the carriage should follow; or a function that draws one for each episode, given a
        numpy Generator. By default a step to a target drawn within the stroke.
    duration, period
        Length of an episode and of a step, s.
    ranges, factors
        What differs from rig to rig; nothing by default.
    reward
        Reward of a sample by error (m, reference less true position) and change of the command (V).

    Examples
    --------
    >>> env = RigEnv(duration=0.01)
    >>> observation, info = env.reset(seed=1)
    >>> observation, reward, terminated, truncated, info = env.step([6.0])
    >>> truncated, info["time"]
    (False, 0.001)
    """

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012  as gymnasium has it

    def __init__(
        self,
        rig: RigParameters | None = None,
        reference: Reference | Callable[[np.random.Generator], Reference] | None = None,
        duration: float = 6.0,
        period: float = 1e-3,
        ranges: Mapping[str, object] | None = None,
        factors: Mapping[str, object] | None = None,
        reward: Callable[[float, float], float] = reward,
    ) -> None:
        """Make the environment; raises as :func:`rodless_lab.draw` and ``closed_loop``."""
        self._base = RigParameters.preset("calibrated") if rig is None else rig
        if not (reference is None or callable(reference) or hasattr(reference, "sample")):
            raise TypeError(
                f"{shown(reference)} is no reference: give one, or a function that draws one"
            )
        self._reference = reference
        self._ranges = {} if ranges is None else ranges
        self._factors = {} if factors is None else factors
        if not callable(reward):
            raise TypeError(
                f"reward {shown(reward)} refused: must be a function of error (m) and jump (V)"
            )
        self._reward = reward
        span = step_nanoseconds(period, "period")
        self._period = span * SECONDS_PER_NANOSECOND
        count = sample_count(nanoseconds(duration), span)
        refuse_more_than_there_is(
            8 * NUMBERS_PER_SAMPLE * count,
            f"duration {shown(duration)} s refused: {count} samples",
            "shorten it, or lengthen the period",
        )
        self._times = sample_times(count, span)
        bounds = np.array([limits for _, *limits in OBSERVATION])
        self.observation_space = Box(bounds[:, 0], bounds[:, 1], dtype=np.float64)
        self.action_space = Box(MINIMUM_VOLTAGE, MAXIMUM_VOLTAGE, (1,), dtype=np.float64)
        self._rig = Rig(self._drawn(1))
        self._over = True

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Begin an episode at rest; return its first observation.

        ``options={"rig": RigParameters(...)}`` chooses the rig, seed of the sensors and all. Raises
        ValueError for other options, for a function that draws references and fails, and for a
        reference beyond any rig, faster than ``FASTEST`` or that raises, TypeError for what is no
        reference. There is no episode then.
        """
        given = {} if options is None else options
        if not isinstance(given, Mapping):
            raise TypeError(f"options {shown(given)} refused: must be a dictionary")
        for name in given:
            if name != "rig":
                raise ValueError(f"option {shown(name)} refused: there is rig")
        # Until there is another one, the last episode is over, whatever is wrong with it.
        self._over = True
        super().reset(seed=seed)
        drawn = self._drawn(int(self.np_random.integers(LARGEST_SEED)))
        parameters = given.get("rig", drawn)
        if not isinstance(parameters, RigParameters):
            raise TypeError(f"option rig {shown(parameters)} refused: must be RigParameters")
        self._rig = Rig(parameters)
        self._points = sampled(self._drawn_reference(), self._times)
        refuse_beyond_any_rig(self._points[:, 0], self._times)
        _refuse_faster(self._points[:, 1], self._times)
        self._sample, self._over = 0, False
        self._voltage = self._rig.state.voltage
        return self._observed()

    def _drawn(self, seed: int) -> RigParameters:
        (found,) = draw(self._ranges, 1, self._base, seed, factors=self._factors)
        return found

    def _drawn_reference(self) -> Reference:
        if self._reference is None:
            stroke = self._rig.parameters.number("cylinder.stroke")
            target = float(self.np_random.uniform(0.05, 0.95)) * stroke
            return references.step(self._rig.state.position, target, at=0.1)
        if hasattr(self._reference, "sample"):
            return self._reference
        drawn: Reference = _called("reference", self._reference, self.np_random)
        return drawn

    def step(self, action: Any) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Apply a voltage, shape (1,), for one period.

        An episode is truncated at its last sample, and terminated where the motion leaves what a
        rig can do; ``info["failure"]`` says how.

        Raises ValueError for what is not one voltage, ResetNeeded where no episode is under way.
        A reward function that raises, or gives no finite number, is a ValueError or TypeError, and
        ends the episode.
        """
        if self._over:
            raise ResetNeeded("no episode is under way: call reset() first")
        given = applied_voltages(action)
        if given.size != 1:
            raise ValueError(f"action {shown(action)} refused: must be one voltage, shape (1,)")
        voltage = float(given[0])
        jump, self._voltage = voltage - self._voltage, voltage
        failure = ""
        try:
            self._rig.advance(voltage, self._period)
            self._sample += 1
        except SimulationError as error:
            failure = str(error)
        observation, info = self._observed()
        error_now = float(self._points[self._sample, 0]) - self._rig.state.position
        over = self._sample == len(self._times) - 1
        gained = FAILURE if failure else self._rewarded(error_now, jump)
        self._over = over or bool(failure)
        return observation, gained, bool(failure), over, {**info, "failure": failure}

    def _rewarded(self, error: float, jump: float) -> float:
        """Return what the reward function gives; an episode without a reward is over."""
        self._over = True
        given = _called("reward", self._reward, error, jump)
        name = function_name(self._reward)
        found = single_number(given, f"reward: {name} gives", "any size")
        if not math.isfinite(found):
            raise ValueError(f"reward: {name} gives {shown(given)} refused: must be finite")
        return found

    def close(self) -> None:
        """End the episode, if one is under way."""
        self._over = True
        super().close()

    @property
    def measurement(self) -> Measurement:
        """What the instruments read now, as a law of this package takes it."""
        return self._rig.read()

    def _observed(self) -> tuple[Array, dict[str, Any]]:
        read = self.measurement
        found = np.array([*read[1:], *self._points[self._sample]], dtype=np.float64)
        state = self._rig.state
        return found, {"time": state.time, "position": state.position, "stamp": read.stamp}


def _refuse_faster(velocities: Array, times: Array) -> None:
    """Raise ValueError for a reference whose velocity (m/s) no observation may have."""
    beyond = np.flatnonzero(np.abs(velocities) > FASTEST)
    if beyond.size:
        first = beyond[0]
        raise OneLineError(
            f"at {times[first]:g} s: the reference moves at {velocities[first]:g} m/s, must be "
            f"from {-FASTEST:g} to {FASTEST:g} m/s; velocities are in m/s"
        )


def _called(what: str, function: Callable[..., Any], *arguments: object) -> Any:
    """Call a function of the user's; raises ValueError, with its name, where it raises."""
    try:
        return function(*arguments)
    except Exception as error:
        name = function_name(function)
        raise ValueError(f"{what} {name} refused: it raises {traced(error)}") from error


gymnasium.register(id="Rodless-v0", entry_point="rodless_lab.gym:RigEnv")
