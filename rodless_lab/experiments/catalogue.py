"""Every experiment by name, in the order of the paper: one module of this folder each."""

from collections.abc import Sequence
from importlib import import_module

from rodless_lab.experiments.experiment import Experiment

MODULES = (
    "valve_area",
    "flow_coefficient",
    "friction",
    "fixed_chamber",
    "step",
    "sine",
    "errata",
)


def experiments_of(modules: Sequence[str]) -> dict[str, Experiment]:
    """Return the ``EXPERIMENT`` of each module of this folder, by its name."""
    found = (import_module(f"{__package__}.{module}").EXPERIMENT for module in modules)
    return {experiment.name: experiment for experiment in found}


EXPERIMENTS = experiments_of(MODULES)
