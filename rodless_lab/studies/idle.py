# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Parameters that only nodes or another reference read: in a study they would do nothing."""

from collections.abc import Sequence

from rodless_base.one_line import listed
from rodless_control.parameters import REFERENCE
from rodless_control.setpoint import FROM_PARAMETERS
from rodless_lab.studies.base import Base

# What a study has in their place.
INSTEAD = {"time.period": "set run.period", "time.duration": "set run.duration"}


def idle_parameters(base: Base) -> set[str]:
    """Return the names of those that are for nodes alone, and of other references' parameters."""
    declared = [*base.rig.DECLARATIONS.values(), *base.controller.DECLARATIONS.values()]
    of_nodes = {one.name for one in declared if not one.in_runs}
    used = FROM_PARAMETERS[base.controller.text("reference.type")]
    return of_nodes | (REFERENCE.keys() - {"reference.type", *used})


def idle(names: Sequence[str]) -> str:
    """Say why a study cannot have ``names``, and what to do."""
    ways_out = [INSTEAD[name] for name in names if name in INSTEAD]
    return (
        f"refused: no run of this study depends on {listed(names)}; "
        f"{' and '.join(ways_out) or 'leave it out'}"
    )
