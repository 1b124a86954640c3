# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Each node's parameters are told from the other's by their names."""

import pytest

from rodless_base.owners import GROUPS, owner
from rodless_base.parameters import ParameterError, ParameterSet
from rodless_control import ControllerParameters, PidParameters
from rodless_control.laws import LAWS, law_class
from rodless_sim import RigParameters
from rodless_sim.physics.forces import FORCES

SETS: dict[str, type[ParameterSet]] = {"plant": RigParameters, "controller": ControllerParameters}


@pytest.mark.parametrize("node", SETS)
def test_the_groups_are_those_that_the_node_declares(node: str) -> None:
    """The table repeats what is declared: no group is missing, and none is left over.

    A force of one's own may have a group that only the plant knows.
    """
    own = {name.partition(".")[0] for force in FORCES for name in getattr(force, "PARAMETERS", ())}
    names = [*SETS[node].DECLARATIONS]
    if node == "controller":
        names += (name for law in LAWS for name in law_class(law).PARAMETERS)
    declared = {name.partition(".")[0] for name in names if "." in name}
    assert declared - own <= set(GROUPS[node]) <= declared


def test_no_group_belongs_to_two_nodes() -> None:
    """Each name has one owner at most."""
    assert not set(GROUPS["plant"]) & set(GROUPS["controller"])
    assert owner("no.such") is None


@pytest.mark.parametrize(
    ("kind", "name", "whose"),
    [
        (RigParameters, "controller.kp", "it is the controller's"),
        (RigParameters, "reference.type", "it is the controller's"),
        (ControllerParameters, "supply.pressure", "it is the plant's"),
        (PidParameters, "friction.form", "it is the plant's"),
        (RigParameters, "adrc.dead_zone_voltage", "it is the controller's"),
    ],
)
def test_a_name_of_the_other_node_is_refused_as_such(
    kind: type[ParameterSet], name: str, whose: str
) -> None:
    """Who puts a value into the wrong section is told where it belongs."""
    with pytest.raises(ParameterError, match=whose):
        kind({name: 1.0})
