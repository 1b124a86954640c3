# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What pages offer are parameters that the nodes have, within their ranges."""

import pytest

from rodless_base.parameter_file import preset_names
from rodless_control import ControllerParameters
from rodless_control.laws import LAWS, law_class
from rodless_lab.view.panels import LAW, PANELS, REFERENCES, Choice, Field
from rodless_sim import RigParameters

DECLARED = {**RigParameters.DECLARATIONS, **ControllerParameters.DECLARATIONS}
for law in LAWS:
    DECLARED |= law_class(law).PARAMETERS
OFFERED = [field for panel in PANELS for field in panel.fields]
FIELDS = [field for field in OFFERED if isinstance(field, Field)]
FIELDS += [field for fields in REFERENCES.values() for field in fields]
CHOICES = [field for field in OFFERED if isinstance(field, Choice)]


@pytest.mark.parametrize("field", FIELDS, ids=lambda field: field.name)
def test_a_slider_goes_no_farther_than_its_parameter(field: Field) -> None:
    """Both ends, and the default, are values that the node takes."""
    declared = DECLARED[field.name]
    for end in (field.low, field.high):
        declared.check(field.own(end))
    assert isinstance(declared.default, float)
    assert field.low <= field.shown(declared.default) <= field.high


@pytest.mark.parametrize("preset", preset_names())
def test_a_preset_is_within_the_sliders(preset: str) -> None:
    """A knob at the end of its slider would not show where its parameter is."""
    values = {**RigParameters.preset(preset), **ControllerParameters.preset(preset)}
    shown = {field.name: field for field in FIELDS if field.name in values}
    assert len(shown) > 20
    for name, field in shown.items():
        value = values[name]
        assert isinstance(value, float)
        assert field.low <= field.shown(value) <= field.high, name


@pytest.mark.parametrize("field", FIELDS, ids=lambda field: field.name)
def test_what_is_shown_is_what_is_set(field: Field) -> None:
    """A value read back is the value that was entered."""
    middle = round(0.5 * (field.low + field.high), 3)
    assert field.shown(field.own(middle)) == middle


@pytest.mark.parametrize("choice", CHOICES, ids=lambda choice: choice.name)
def test_a_list_has_what_its_parameter_can_be(choice: Choice) -> None:
    """Each entry is a value that the node takes, and none is left out."""
    declared = DECLARED[choice.name]
    assert [declared.check(value) for value in choice.options] == list(choice.options)
    possible = set(LAWS) if choice.name == LAW else set(declared.choices) or {False, True}
    assert set(choice.options) == possible


@pytest.mark.parametrize("law", LAWS)
def test_each_law_has_something_to_set(law: str) -> None:
    """Of a law of the package the page shows more than its name."""
    assert law_class(law).PARAMETERS.keys() & {field.name for field in FIELDS}
