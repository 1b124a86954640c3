# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What an experiment is, and what its user may choose."""

from collections.abc import Callable
from dataclasses import dataclass

from rodless_lab.experiments.result import Result
from rodless_lab.experiments.runner import IN_PROCESS, Runner


@dataclass(frozen=True)
class Options:
    """What a user may choose. Each experiment takes what its ``takes`` names."""

    presets: tuple[str, ...] = ("paper", "calibrated")  # whose step and sine
    amplitude: float = 0.020  # m, of the sine
    centre: float = 0.100  # m, of the sine
    position: float = 0.0  # m, of the held piston
    seed: int = 1  # of the sensors' noise
    runner: Runner = IN_PROCESS


@dataclass(frozen=True)
class Experiment:
    """One experiment of the paper.

    ``takes`` names the fields of :class:`Options` that concern it; ``moves``: it drives a rig, so
    the nodes can do it.
    """

    name: str
    title: str
    source: str
    summary: str
    run: Callable[[Options], Result]
    takes: tuple[str, ...] = ()
    moves: bool = False
