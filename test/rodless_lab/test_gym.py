# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The Gymnasium environment: as gymnasium wants it, and the same rig as everywhere else."""

import math
import re
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from rodless_control import Pid, PidParameters, ReferencePoint, references
from rodless_lab import closed_loop
from rodless_lab.gym import FAILURE, RigEnv
from rodless_sim import RigParameters, SimulationError

STEP = references.step(0.0, 0.058, at=0.1)
NOISY = RigParameters.preset("calibrated").with_values(
    {"sensors.position_noise": 2e-5, "sensors.pressure_noise": 200.0, "sensors.pressure_lag": 5e-3}
)


def test_gymnasium_finds_nothing_wrong() -> None:
    """Its own check of spaces, seeds and answers, with random rigs.

    Of its warnings there is one: an action should be normalised, and not in V. RescaleAction does.
    """
    env = RigEnv(NOISY, duration=0.2, ranges={"cylinder.moving_mass": (0.7, 2.0)})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", ".*symmetric and normalized space", UserWarning)
        check_env(env, skip_render_check=True)


def test_a_misspelt_option_is_refused() -> None:
    """An episode on another rig than the one that was meant would be taken for it."""
    env = RigEnv(NOISY, STEP, duration=0.8)
    with pytest.raises(ValueError, match="option 'rigs' refused: there is rig"):
        env.reset(options={"rigs": NOISY})
    for none in (None, "calibrated", dict(NOISY)):
        with pytest.raises(TypeError, match=r"^option rig .* refused: must be RigParameters$"):
            env.reset(options={"rig": none})


def test_a_law_through_it_answers_with_the_bits_of_the_closed_loop() -> None:
    """Sample by sample: readings with noise and lag, voltages and true positions."""
    rig = NOISY.with_values({"sensors.seed": 11})
    law = PidParameters.preset("calibrated")
    expected = closed_loop(rig, law, STEP, 0.8, 1e-3)
    env, pid = RigEnv(NOISY, STEP, duration=0.8), Pid(law)
    observation, info = env.reset(seed=1, options={"rig": rig})
    for k in range(801):
        assert info["position"] == expected.true_position[k]
        assert tuple(observation[:3]) == (
            expected.position[k], expected.pressure_a[k], expected.pressure_b[k]
        )  # fmt: skip
        reference = ReferencePoint(*observation[4:])
        voltage = pid.update(env.measurement, reference, 1e-3 if k else 0.0).voltage
        assert voltage == expected.voltage[k]
        if k < 800:
            observation, _, terminated, truncated, info = env.step([voltage])
            assert (terminated, truncated) == (False, k == 799)


def test_an_episode_follows_from_its_seed() -> None:
    """The same seed gives the same rig, target and noise; another one others."""
    env = RigEnv(NOISY, duration=0.05, ranges={"supply.pressure": (5e5, 7e5)})

    def episode(seed: int) -> np.ndarray:
        first, _ = env.reset(seed=seed)
        return np.array([first, *(env.step([6.0])[0] for _ in range(20))])

    assert np.array_equal(episode(3), episode(3))
    assert not np.array_equal(episode(3), episode(4))


def test_episodes_without_a_seed_go_on_from_the_last() -> None:
    """Rigs differ within a training run, and the run can be repeated."""
    env = RigEnv(NOISY, duration=0.05)

    def three() -> list[tuple[float, ...]]:
        found = [env.reset(seed=5)[0], env.reset()[0], env.reset()[0]]
        return [tuple(one.tolist()) for one in found]

    assert three() == three()
    assert len(set(three())) == 3


def test_the_reward_is_the_users_own() -> None:
    """It is given the true error and the change of the command."""
    told: list[tuple[float, float]] = []

    def reward(error: float, jump: float) -> float:
        told.append((error, jump))
        return 7.0

    env = RigEnv(reference=STEP, duration=0.3, reward=reward)
    env.reset(seed=1)
    gained = {env.step([voltage])[1] for voltage in (5.5, 6.0, 20.0)}
    assert gained == {7.0}
    assert [jump for _, jump in told[1:]] == [0.5, 4.0]  # 20 V are 10 V
    assert told[0][0] == pytest.approx(0.0, abs=1e-6)


def test_a_motion_that_leaves_the_rig_ends_the_episode(monkeypatch: pytest.MonkeyPatch) -> None:
    """With the sentence of the error; the reward is a penalty."""
    env = RigEnv(duration=0.05)
    env.reset(seed=1)

    def fails(*_: float) -> None:
        raise SimulationError("no rig does that")

    monkeypatch.setattr(env._rig, "advance", fails)
    _, gained, terminated, truncated, info = env.step([6.0])
    assert (gained, terminated, truncated) == (FAILURE, True, False)
    assert info["failure"] == "no rig does that"


def test_an_episode_without_end_is_refused() -> None:
    """Before any memory is taken; the line names duration, samples and what there is."""
    with pytest.raises(
        ValueError, match=r"^duration 1000000000.0 s refused: 1000000000001 samples"
    ):
        RigEnv(duration=1e9)


def test_past_its_end_an_episode_says_what_to_do() -> None:
    """A step before the first reset too; after a reset it goes on."""
    env = RigEnv(duration=0.002)
    for _ in range(2):
        with pytest.raises(gymnasium.error.ResetNeeded, match=r"call reset\(\)"):
            env.step([5.0])
        env.reset(seed=1)
        assert [env.step([5.0])[3] for _ in range(2)] == [False, True]


def test_several_rigs_side_by_side_are_those_alone() -> None:
    """Each of a vector has the readings of its seed; an episode that ends is begun anew."""
    ranges = {"cylinder.moving_mass": (0.7, 2.0)}
    several = gymnasium.make_vec(
        "Rodless-v0", 3, "sync", rig=NOISY, reference=STEP, duration=0.02, ranges=ranges
    )
    found = [several.reset(seed=4)[0]]
    for _ in range(20):
        observations, _, _, truncated, _ = several.step(np.full((3, 1), 6.0))
        found.append(observations)
    assert truncated.all()
    several.step(np.full((3, 1), 6.0))
    assert not several.step(np.full((3, 1), 6.0))[3].any()
    several.close()
    for place in range(3):
        env = RigEnv(NOISY, STEP, duration=0.02, ranges=ranges)
        alone = [env.reset(seed=4 + place)[0], *(env.step([6.0])[0] for _ in range(20))]
        assert np.array_equal([one[place] for one in found], alone)


@pytest.mark.parametrize(
    "action", [[1.0, 2.0], [], [float("nan")], None, "6", [[]], {"a": 1.0}], ids=repr
)
def test_what_is_not_one_voltage_is_refused_and_changes_nothing(action: object) -> None:
    """In one line; the episode goes on with a voltage."""
    env = RigEnv(reference=STEP, duration=0.01)
    env.reset(seed=1)
    with pytest.raises(ValueError, match=r"refused|no voltages given") as refusal:
        env.step(action)
    assert "\n" not in str(refusal.value)
    assert env.step([6.0])[4]["time"] == 1e-3


def test_a_reference_in_millimetres_is_refused() -> None:
    """As closed_loop does, at the reset that draws it."""
    env = RigEnv(reference=references.step(0.0, 58.0, at=0.1), duration=0.3)
    with pytest.raises(ValueError, match=r"asks for 58 m, must be from .* positions are in m"):
        env.reset(seed=1)


def test_observations_stay_within_their_bounds() -> None:
    """A reference that would leave them is refused with its first such sample; none begins then."""
    fast = references.sine(0.1, 0.05, 5000.0)
    env = RigEnv(NOISY, fast, duration=0.05, period=1.1e-4)
    with pytest.raises(
        ValueError, match=r"^at ([\d.e-]+) s: the reference moves at (\S+) m/s, mu"
    ) as no:
        env.reset(seed=1)
    when, velocity = map(float, re.findall(r"at (\S+) ", str(no.value)))
    assert velocity == pytest.approx(fast.sample(when)[1], rel=1e-4)
    assert abs(velocity) > 1000.0
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step([5.0])
    slower = RigEnv(NOISY, references.sine(0.1, 0.05, 3000.0), duration=0.05, period=1.1e-4)
    observation, _ = slower.reset(seed=1)
    assert observation in slower.observation_space


def test_a_sensor_that_is_gone_reads_nan() -> None:
    """As docs/gym.md says; the others go on."""
    env = RigEnv(NOISY.with_values({"fault.position.sensor": "gone"}), STEP, duration=0.05)
    env.reset(seed=1)
    observation, *_ = env.step([5.0])
    assert np.isnan(observation).tolist() == [True, False, False, False, False, False]


def test_a_function_that_draws_no_reference_is_named_with_what_it_raises() -> None:
    """One of C, too, which leaves no line of its own in the traceback."""

    def wrong(_generator: object) -> references.Reference:
        raise KeyError("speed")

    for drawn, cause in ((math.sin, "TypeError: must be real"), (wrong, "KeyError: 'speed'")):
        env = RigEnv(reference=drawn, duration=0.3)
        with pytest.raises(
            ValueError, match=f"^reference .* refused: it raises {cause}"
        ) as refusal:
            env.reset(seed=1)
        assert "\n" not in str(refusal.value)
        assert "0x" not in str(refusal.value)


def test_a_reset_that_is_refused_leaves_no_episode() -> None:
    """Half of the old one and half of the new one would be neither."""
    drawn = iter([STEP, 3.0])
    env = RigEnv(reference=lambda _generator: next(drawn), duration=0.3)
    env.reset(seed=1)
    env.step([6.0])
    with pytest.raises(TypeError):
        env.reset()
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step([6.0])


@pytest.mark.parametrize(
    ("odd", "cause"),
    [
        (math.nan, "gives nan refused: must be finite"),
        (10**400, "refused: must be finite"),
        ("1", "gives '1' refused: must be a number"),
        (None, "gives None refused: must be a number"),
        (True, "gives True refused: must be a number"),
        (np.timedelta64(1, "s"), "refused: must be a number"),
        (ZeroDivisionError("no jump"), "raises ZeroDivisionError: no jump"),
    ],
    ids=repr,
)
def test_a_reward_that_is_none_is_refused_and_ends_the_episode(odd: object, cause: str) -> None:
    """Named with what it gives or raises; nothing else would come of its next sample."""

    def odd_reward(_error: float, _jump: float) -> Any:
        if isinstance(odd, Exception):
            raise odd
        return odd

    env = RigEnv(reward=odd_reward, reference=STEP, duration=0.3)
    env.reset(seed=1)
    with pytest.raises((TypeError, ValueError), match=f"reward.*odd_reward.*{cause}") as refusal:
        env.step([6.0])
    assert "\n" not in str(refusal.value)
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step([6.0])


def test_a_closed_environment_has_no_episode() -> None:
    """And options are a dictionary."""
    env = RigEnv(reference=STEP, duration=0.3)
    env.reset(seed=1)
    env.close()
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step([6.0])
    with pytest.raises(TypeError, match="options 5 refused: must be a dictionary"):
        env.reset(options=5)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "given",
    [{"reward": 5}, {"ranges": 3.0}, {"factors": [1]}, {"reference": 0.1}, {"rig": {}}],
    ids=repr,
)
def test_arguments_of_another_kind_are_refused(given: dict[str, Any]) -> None:
    """In one line that shows them."""
    (odd,) = given.values()
    with pytest.raises((TypeError, ValueError), match=re.escape(repr(odd))):
        RigEnv(**given)


def test_it_is_made_by_its_name() -> None:
    """As other environments are, several at once too."""
    env = gymnasium.make("Rodless-v0", duration=0.05)
    assert isinstance(env.unwrapped, RigEnv)
    several = gymnasium.make_vec("Rodless-v0", num_envs=3, duration=0.05)
    observations, _ = several.reset(seed=1)
    assert observations.shape == (3, 6)
    assert len(set(observations[:, 4])) == 1  # before the step all hold


def test_the_page_of_the_docs_runs() -> None:
    """Its example comes to the end of an episode."""
    page = (Path(__file__).parents[2] / "docs" / "gym.md").read_text(encoding="utf-8")
    (snippet,) = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    scope: dict[str, object] = {}
    exec(compile(snippet, "gym.md", "exec"), scope)
    assert scope["truncated"] is True


def test_without_gymnasium_it_says_how_to_get_it() -> None:
    """In one line, and only where it is asked for."""
    script = (
        "import sys\nsys.modules['gymnasium'] = None\nimport rodless_lab\n"
        "try:\n    import rodless_lab.gym\nexcept ModuleNotFoundError as error:\n    print(error)"
    )
    run = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=300, check=True
    )
    assert run.stdout.strip().endswith("pip install 'rodless_sim[gym]'")
