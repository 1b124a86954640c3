# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.


"""A plant that gets an option it has never had goes on while its equations are compiled."""

import time
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import pytest
from extent import extensive
from sensor_msgs.msg import JointState

from rodless_lab.harness import RigSession
from rodless_lab.session.errors import NotYetError, WaitTimeoutError
from rodless_lab.session.observer import Observer

DROOP = {"supply.droop": 1e4}
RIPPLE = {"supply.ripple_amplitude": 1e3}


@extensive
@pytest.mark.slow
def test_the_plant_goes_on_and_takes_the_change_once_it_is_compiled(tmp_path: Path) -> None:
    """With an empty cache: refused by a reason that says when to ask again, and then taken.

    A session asks again by itself. Samples come all the while: compared with the time that
    compiling takes, in which none would come if the plant did it.
    """
    with RigSession(
        controller=None,
        plant={"time.period": 5e-3},
        environment={"XDG_CACHE_HOME": str(tmp_path)},
        timeout=300.0,
    ) as rig:
        heard: list[float] = []
        rig.observer.subscribe(JointState, "joint_states", lambda _: heard.append(time.monotonic()))
        rig.wait_until(lambda: heard, "samples")
        with pytest.raises(NotYetError, match=r"^not yet: supply\.droop wants other equations"):
            rig.observer.set_parameters("plant", DROOP)
        assert rig.parameters("plant", list(DROOP)) == {"supply.droop": 0.0}
        with pytest.raises(NotYetError, match=r"^not yet: supply\.ripple_amplitude wants"):
            rig.observer.set_parameters("plant", RIPPLE)
        refused = time.monotonic()
        rig.set_parameters("plant", DROOP)
        compiling = time.monotonic() - refused
        assert rig.parameters("plant", list(DROOP)) == DROOP
        rig.wait_until(lambda: heard[-1] > refused + compiling, "a sample with the new equations")
        assert "supply.droop: compiled, and can be set now" in rig.outputs["plant"]
    gaps = [after - before for before, after in pairwise(heard)]
    assert max(gaps) < 0.25 * compiling


def test_a_change_is_asked_for_until_it_is_taken() -> None:
    """Whoever waits is told once; what takes too long is named, with its cause."""
    answers: list[object] = [NotYetError("not yet: a"), NotYetError("not yet: b"), "taken"]
    told: list[str] = []
    pauses: list[float] = []

    def change() -> object:
        answer = answers.pop(0)
        if isinstance(answer, Exception):
            raise answer
        return answer

    waiting = cast(Observer, SimpleNamespace(_pause=pauses.append))
    assert Observer.once_ready(waiting, change, 60.0, lambda: told.append("once")) == "taken"
    assert told == ["once"]
    assert len(pauses) == 2
    answers[:] = [NotYetError("not yet: c")]
    with pytest.raises(WaitTimeoutError, match=r"timed out after -1 s: not yet: c"):
        Observer.once_ready(waiting, change, -1.0)
