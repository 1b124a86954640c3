# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The plant's log says what its scenario changes, and why it stands still, in each run anew."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import pytest
from rclpy.parameter import Parameter

from rodless_lab.session.observer import Observer
from rodless_sim.node.plant_node import PlantNode

pytestmark = pytest.mark.ros

SCENARIO = """
- {at: 0.0, fault.position.offset: 1.0e-3}
- {at: 0.02, fault.position.offset: 2.0e-3}
"""


class Told(NamedTuple):
    """A plant that nothing spins, and the lines of its log."""

    plant: PlantNode
    lines: list[str]

    def step(self, count: int) -> None:
        """Let so many periods of 10 ms pass without a look at the scenario."""
        for _ in range(count):
            self.plant._engine.step()

    def look(self, begins: str = "scenario at") -> list[str]:
        """Look at the scenario; return what is said that ``begins`` so."""
        self.lines.clear()
        self.plant._poll()
        return [line for line in self.lines if line.startswith(begins)]


class Log:
    """Takes what is logged at any level."""

    def __init__(self, lines: list[str]) -> None:
        self._lines = lines

    def __getattr__(self, _level: str) -> Callable[..., None]:
        """Return what takes a line."""
        return lambda line, **_: self._lines.append(line)


@pytest.fixture
def told(observer: Observer, tmp_path: Path) -> Iterator[Told]:
    """Return a plant with a scenario that has an entry at the start and one at 20 ms."""
    path = tmp_path / "scenario.yaml"
    path.write_text(SCENARIO)
    given = {"time.mode": "lockstep", "time.period": 1e-2, "time.scenario": str(path)}
    overrides = [Parameter(name, value=value) for name, value in given.items()]
    plant = PlantNode(context=observer.context, namespace="/told", parameter_overrides=overrides)
    lines: list[str] = []
    plant.node.get_logger = lambda: Log(lines)
    yield Told(plant, lines)
    plant.close()


def test_each_run_tells_all_of_its_scenario(told: Told) -> None:
    """What is due at its start, too, which a reset has brought back before anybody looks."""
    first, second = "scenario at 0 s: fault.position.offset", "scenario at 0.02 s: fault.position"
    assert [line[: len(first)] for line in told.look()] == [first]
    told.step(3)
    assert [line[: len(second)] for line in told.look()] == [second]
    assert told.look() == []
    told.plant._engine.reset()
    assert [line[: len(first)] for line in told.look()] == [first]
    told.step(3)
    assert len(told.look()) == 1


def test_a_run_that_is_soon_where_the_one_before_was_tells_it_all(told: Told) -> None:
    """In lock-step hundreds of samples may pass between two looks."""
    told.step(3)
    assert len(told.look()) == 2
    told.plant._engine.reset()
    told.step(3)
    assert len(told.look()) == 2


def test_a_run_that_fails_as_the_one_before_says_so(told: Told) -> None:
    """In lock-step it may have done so before anybody looks."""
    for _ in range(2):
        told.plant._engine.reset()
        told.plant._engine.fail("too fast")
        assert told.look("too fast") == ["too fast; valve closed, reset to go on"]
        assert told.look("too fast") == []
