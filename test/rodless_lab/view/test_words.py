# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What the drawing shows, in words."""

import pytest

from rodless_lab.view import words
from rodless_lab.view.samples import COLUMNS, Row


def row(**values: float) -> Row:
    """Return a row with these columns and nothing else."""
    return tuple(values.get(name) for name in COLUMNS)


@pytest.mark.parametrize(
    ("velocity", "text"),
    [
        (0.0, "■ stuck"),
        (0.0123, "▶ slipping, 12.3 mm/s"),
        (-0.00012, "◀ slipping, 0.12 mm/s"),
    ],
)
def test_a_carriage_sticks_or_slips(velocity: float, text: str) -> None:
    """It sticks where its velocity is exactly 0, however slowly it creeps otherwise."""
    assert words.motion(row(velocity=velocity)) == text


def test_a_seized_carriage_is_said_to_be() -> None:
    """Whatever the friction would do; the piston has its own word."""
    seen = row(velocity=0.0, piston_velocity=-0.5)
    assert words.motion(seen, seized=True) == "carriage ■ seized; piston ◀ slipping, 500.0 mm/s"


def test_nothing_is_said_of_what_is_not_known() -> None:
    """Of a rig without velocities, and of one that tells neither command nor spool."""
    assert words.motion(row(position=0.1)) == ""
    assert words.valve(row(position=0.1), 5.08) == ""
    assert not words.is_lost(row(position=0.1))


@pytest.mark.parametrize(
    ("voltage", "text"),
    [(5.08, "closed"), (5.1, "A fills, B empties"), (0.0, "B fills, A empties")],
)
def test_the_spool_opens_what_its_place_says(voltage: float, text: str) -> None:
    """Of a rig that says where it is, by that; of another, by the command."""
    assert words.valve(row(voltage=voltage), 5.08) == text
    assert words.valve(row(voltage=7.0, spool=voltage), 5.08) == text
    assert words.valve(row(voltage=7.0, spool=voltage), 5.08, stuck=True) == f"spool stuck: {text}"
