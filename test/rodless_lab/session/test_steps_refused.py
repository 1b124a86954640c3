# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What a step of a session does where the plant does not take it; without ROS."""

from collections.abc import Callable
from types import SimpleNamespace

import pytest

from rodless_lab.session.errors import RefusedError
from rodless_lab.session.plant_time import PlantTime
from rodless_sim.node.time_keeper import NO_COMMAND_YET


class Session(PlantTime):
    """A paused session whose plant answers as given."""

    _paused = _inside = True
    _has_ended = False  # type: ignore[assignment]

    def __init__(self, *answers: str) -> None:
        super().__init__()
        self.answers = list(answers)

    def _call_once(self, _service: str, _has_worked: Callable[[], object]) -> SimpleNamespace:
        message = self.answers.pop(0)
        return SimpleNamespace(success=not message, message=message)

    def _wait(self, condition: Callable[[], object], *_: object, **__: object) -> None:  # type: ignore[override]
        while not condition():
            pass

    def _run_until(self, *_: object) -> str:  # type: ignore[override]
        return "the sample"


def test_a_step_waits_for_a_command_and_for_nothing_else() -> None:
    """The command will come; what has failed will not mend itself, and its reason is told."""
    session = Session(NO_COMMAND_YET, NO_COMMAND_YET, "", "after 0.1 s: no air; reset to go on")
    assert session.step() == "the sample"
    with pytest.raises(RefusedError, match=r"^plant/step: after 0\.1 s: no air; reset to go on$"):
        session.step()
    assert session.answers == []
