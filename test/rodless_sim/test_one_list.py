# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The state is listed once: traces, records, messages and docs follow from that list."""

from pathlib import Path

import numpy as np
import pytest
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState

from rodless_base.columns import quantities
from rodless_base.measurement import Measurement
from rodless_base.topics import PRESSURE_FRAMES
from rodless_lab import ClosedLoopTrace
from rodless_lab.reports.parameters import parameter_reference
from rodless_sim import HeatedState, Rig, RigParameters, State, Trace, simulate
from rodless_sim.node import messages
from rodless_sim.physics.state import FURTHER, HeatedMotion, Motion, state_with
from rodless_sim.trace import COLUMNS, HEATED_COLUMNS

NAMES = [quantity.name for quantity in quantities(State)]
RUN = simulate(RigParameters(), [6.0] * 20, 1e-3)


def test_every_field_of_the_state_has_a_unit_and_a_meaning() -> None:
    """None is forgotten, and what the plant integrates is part of it, alike."""
    assert list(State._fields) == NAMES
    assert all(quantity.unit and quantity.meaning for quantity in quantities(State))
    assert set(quantities(Motion)) <= set(quantities(State))
    assert [quantity.name for quantity in quantities(Motion)] == list(Motion._fields)


def test_temperatures_stand_behind_what_every_rig_has() -> None:
    """Both of the state and of a record: what reads the one can read the other."""
    assert quantities(HeatedState)[: len(NAMES)] == quantities(State)
    assert quantities(HeatedMotion)[: len(Motion._fields)] == quantities(Motion)
    assert set(quantities(HeatedMotion)) <= set(quantities(HeatedState))
    assert HEATED_COLUMNS[: len(HeatedMotion._fields)] == HeatedMotion._fields


def test_a_trace_has_the_columns_of_the_list() -> None:
    """In its order, with its units; dir() shows them, and a row is a state."""
    assert list(RUN.columns()) == NAMES
    assert RUN.units() == {quantity.name: quantity.unit for quantity in quantities(State)}
    assert set(NAMES) <= set(dir(RUN))
    rig = Rig()
    for _ in range(20):
        rig.advance(6.0, 1e-3)
    assert [values[-1] for values in RUN.columns().values()] == list(rig.state)


def test_a_closed_loop_adds_its_own_columns() -> None:
    """Behind those of the state, with units of their own; the state's trace has none of them."""
    own = {"reference": np.ones(21), "error": np.zeros(21)}
    run = ClosedLoopTrace(**RUN.columns(), **own)
    assert list(run.columns()) == [*NAMES, *own]
    assert run.units() == {**RUN.units(), "reference": "m", "error": "m"}


def test_type_checkers_know_the_columns_of_a_trace() -> None:
    """The annotations of Trace are the state's fields, in their order, and nothing else."""
    everything = quantities(state_with(tuple(FURTHER)))
    assert list(Trace.__annotations__) == [quantity.name for quantity in everything]
    assert list(Trace.__annotations__)[: len(NAMES)] == NAMES


def test_a_record_begins_with_all_that_is_integrated() -> None:
    """A row holds the motion as it is, then the flows."""
    assert COLUMNS[: len(Motion._fields)] == Motion._fields
    assert set(COLUMNS) <= set(NAMES)


def test_a_trace_cannot_be_changed() -> None:
    """Neither its columns nor anything else, and an attribute it has not is none."""
    for name in ("position", "other"):
        with pytest.raises(AttributeError, match="cannot be changed"):
            setattr(RUN, name, np.zeros(21))
    with pytest.raises(AttributeError, match="cannot be changed"):
        del RUN.position
    with pytest.raises(AttributeError):
        _ = RUN.positon
    RUN.columns().clear()
    assert len(RUN.columns()) == len(NAMES)


def test_a_trace_takes_all_of_its_columns_and_no_others() -> None:
    """A missing or a misspelt column is refused by name."""
    columns = RUN.columns()
    with pytest.raises(TypeError, match=r"missing: \['force'\], unknown: \['forse'\]"):
        Trace(**{name.replace("force", "forse"): values for name, values in columns.items()})
    again = Trace(**dict(reversed(columns.items())))
    assert list(again.columns()) == NAMES


def test_a_trace_shows_itself_in_a_line() -> None:
    """Not as nine arrays."""
    assert repr(RUN) == "Trace: 21 samples, 0.02 s"


def test_everything_that_is_read_is_published() -> None:
    """Messages carry each field of a measurement: stamp and position, and every pressure."""
    assert {"stamp", "position", *PRESSURE_FRAMES} == set(Measurement._fields)


def test_joint_states_hold_readings_and_the_true_velocity() -> None:
    """Effort is A (P_a - P_b) of the pressures read: 490.874 mm² times 1 bar is 49.0874 N."""
    read = Measurement(1_500_000_000, 0.1, 4e5, 3e5, 6e5)
    message = deserialize_message(messages.joint_states()(read, 0.02, 490.874e-6), JointState)
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (1, 500_000_000)
    assert list(message.position) == [0.1]
    assert list(message.velocity) == [0.02]
    assert list(message.effort) == pytest.approx([49.0874])
    assert list(message.name) == ["carriage"]


def test_the_page_lists_the_state() -> None:
    """Name, unit and meaning of each, from the list."""
    page = parameter_reference()
    for name, unit, meaning in quantities(state_with(tuple(FURTHER))):
        assert f"| `{name}` | {unit} | {meaning} |" in page
    written = Path(__file__).resolve().parents[2] / "docs" / "parameters.md"
    assert page == written.read_text(encoding="utf-8")
