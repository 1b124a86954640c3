"""What an experiment is, and what its user may choose."""

from collections.abc import Callable
from dataclasses import dataclass

from rodless_lab.experiments.result import Result
from rodless_lab.experiments.runner import IN_PROCESS, Runner


@dataclass(frozen=True)
class Options:
    """What a user may choose. Each experiment takes what concerns it."""

    presets: tuple[str, ...] = ("paper", "calibrated")  # whose step and sine
    amplitude: float = 0.020  # m, of the sine
    centre: float = 0.100  # m, of the sine
    position: float = 0.0  # m, of the held piston
    seed: int = 1  # of the sensors' noise
    runner: Runner = IN_PROCESS


@dataclass(frozen=True)
class Experiment:
    """One experiment of the paper; ``moves``: it drives a rig, so the nodes can do it."""

    name: str
    title: str
    source: str
    summary: str
    run: Callable[[Options], Result]
    moves: bool = False
