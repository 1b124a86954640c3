"""Every experiment by name, in the order of the paper: one module of this folder each."""

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


def _experiment(module: str) -> Experiment:
    found: Experiment = import_module(f"{__package__}.{module}").EXPERIMENT
    return found


EXPERIMENTS = {one.name: one for one in map(_experiment, MODULES)}
