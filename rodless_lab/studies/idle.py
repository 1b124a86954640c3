# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Parameters that no run of a study depends on: as an axis they would give columns of nothing."""

from rodless_base.parameters import Value
from rodless_control import ControllerParameters
from rodless_control.parameters import REFERENCE
from rodless_control.setpoint import reference_from
from rodless_lab.studies.base import Base

# What a study has in their place.
INSTEAD = {"time.period": "set run.period", "time.duration": "set run.duration"}


def idle_parameters(base: Base) -> set[str]:
    """Return the names of those that are for nodes alone, and of other references' parameters."""
    declared = [*base.rig.DECLARATIONS.values(), *base.controller.DECLARATIONS.values()]
    of_nodes = {one.name for one in declared if not one.in_runs}
    return of_nodes | (REFERENCE.keys() - _read_by_the_reference(base.controller))


def idle(name: str) -> str:
    """Say why ``name`` cannot vary within a study, and what to do."""
    way_out = INSTEAD.get(name, "leave it out")
    return f"{name} refused: no run of this study depends on it; {way_out}"


def _read_by_the_reference(controller: ControllerParameters) -> set[str]:
    """Return the names of what makes the step or sine that ``controller`` follows."""
    read: set[str] = set()

    class Noting(ControllerParameters):
        def __getitem__(self, name: str) -> Value:
            read.add(name)
            return super().__getitem__(name)

    noting = object.__new__(Noting)
    vars(noting).update(vars(controller))
    reference_from(noting)
    return read
