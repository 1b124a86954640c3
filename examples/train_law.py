# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Learn a control law: a small network, trained in the Gymnasium environment, then run by the node.

CMA-ES (the package cmaes, which needs numpy alone) looks for the network's weights over random
rigs, several of which run side by side in a gymnasium vector environment. What it finds is a
parameter file:

pip install 'rodless_sim[gym]' cmaes
python examples/train_law.py learned.yaml
PYTHONPATH=examples rodless rig --preset calibrated --parameters learned.yaml
"""

import sys
from pathlib import Path

import gymnasium
import numpy as np
from cmaes import CMA
from learned_law import FIRST, Learned

import rodless_lab.gym  # noqa: F401  registers Rodless-v0
from rodless_base.measurement import Measurement
from rodless_control import ReferencePoint, references


def cost(weights, envs, seed):
    """Return what an episode costs on average; the law sees what the instruments read."""
    laws = [Learned({"learned.weights": tuple(weights.tolist())}) for _ in range(envs.num_envs)]
    observations, info = envs.reset(seed=seed)
    total, over = 0.0, False
    while not over:
        voltages = [
            [law.update(Measurement(int(stamp), *read[:4]), ReferencePoint(*read[4:]), 1e-3)]
            for law, stamp, read in zip(laws, info["stamp"], observations.tolist(), strict=True)
        ]
        observations, rewards, terminated, truncated, info = envs.step(np.array(voltages))
        total -= float(rewards.mean())
        over = bool((terminated | truncated).any())
    return total


def learn(generations, rigs, duration=0.5, progress=print):
    """Return the weights found: ``rigs`` rigs at a time, each for ``duration`` s."""
    envs = gymnasium.make_vec(
        "Rodless-v0",
        num_envs=rigs,
        vectorization_mode="sync",
        reference=lambda random: references.step(0.0, random.uniform(0.02, 0.1), at=0.02),
        duration=duration,
        ranges={"cylinder.moving_mass": (0.7, 2.0), "supply.pressure": (5e5, 7e5)},
    )
    search = CMA(mean=FIRST.ravel(), sigma=0.3, seed=1)
    best, least = FIRST.ravel(), np.inf
    for generation in range(generations):
        tried = [search.ask() for _ in range(search.population_size)]
        costs = [cost(weights, envs, seed=1) for weights in tried]
        search.tell(list(zip(tried, costs, strict=True)))
        if min(costs) < least:
            least, best = min(costs), tried[int(np.argmin(costs))]
        progress(generation, least)
    envs.close()
    return best


def write(file, weights):
    """Write the law and its weights as a parameter file of the controller node."""
    numbers = ", ".join(map(repr, weights.tolist()))
    file.write_text(
        "/**/controller:\n  ros__parameters:\n    controller.law: learned_law:Learned\n"
        f"    learned.weights: [{numbers}]\n",
        encoding="utf-8",
    )


if __name__ == "__main__":
    write(Path(sys.argv[1] if len(sys.argv) > 1 else "learned.yaml"), learn(40, rigs=4))
