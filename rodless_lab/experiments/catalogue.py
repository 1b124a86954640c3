"""Every experiment by name, in the order of the paper: one module of this folder each."""

from collections.abc import Sequence

from rodless_base.sockets import modules
from rodless_lab.experiments.experiment import Experiment

MODULES = (
    "valve_area",
    "flow_coefficient",
    "friction",
    "fixed_chamber",
    "step",
    "sine",
    "errata",
    "frequency_response",
)


def experiments_of(names: Sequence[str]) -> dict[str, Experiment]:
    """Return the ``EXPERIMENT`` of each module of this folder, by its name."""
    found = (module.EXPERIMENT for module in modules(__package__, names))
    return {experiment.name: experiment for experiment in found}


EXPERIMENTS = experiments_of(MODULES)
