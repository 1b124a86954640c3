# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

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
