# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What a test sends in place of a controller: a lock-step plant that waits for it is told of."""

import pytest

from rodless_lab.session.commands import OwnCommands, RelayedCommands
from rodless_lab.session.errors import HarnessError
from rodless_lab.session.samples import Received, Stamped, Unstamped
from rodless_lab.session.session import RigSession


def one_sample() -> Received:
    """A sample, and the controller's answer to it."""
    received = Received()
    for topic in received.topics:
        topic.put(Stamped(1, 0, (4e5, 0.0, 0.0)))
    received.answers.append(Unstamped(2, 5.5))
    return received


def test_an_alteration_without_a_result_is_refused_where_the_plant_waits() -> None:
    """As one that forgets to return; in real time it is how a command is lost."""
    sent: list[float] = []
    relay = RelayedCommands(one_sample(), sent.append, one_per_sample=True)
    relay.alter = lambda _: None
    with pytest.raises(HarnessError, match="alter_commands: the result is None, and a lock-step"):
        relay.answer()
    in_real_time = RelayedCommands(one_sample(), sent.append, one_per_sample=False)
    in_real_time.alter = lambda _: None
    in_real_time.answer()
    assert sent == []


def test_behind_lost_commands_they_are_altered_as_before() -> None:
    """Also in a block within a block; outside the session's own it is told that it does not run."""
    rig = RigSession(relay_commands=True)
    with pytest.raises(HarnessError, match="this session does not run"):
        rig.alter_commands(None)
    with pytest.raises(HarnessError, match="this session does not run"), rig.commands_lost():
        pass
    sent: list[float] = []
    received = one_sample()
    relay = RelayedCommands(received, sent.append, one_per_sample=False)
    rig._inside, rig._relayed = True, relay
    rig.alter_commands(lambda voltage: -voltage)
    with rig.commands_lost():
        with rig.commands_lost():
            relay.answer()
        received.answers.append(Unstamped(3, 5.6))
        relay.answer()
    assert sent == []
    received.answers.append(Unstamped(4, 5.7))
    relay.answer()
    assert sent == [-5.7]


def test_a_wait_without_a_law_says_that_the_plant_waits() -> None:
    """In lock-step; in real time it goes on by itself."""
    own = OwnCommands(one_sample(), lambda _: None, one_per_sample=True)
    assert own.silence == "; the plant waits for a command to each sample: let drive() answer them"
    own.drive(lambda _: 5.0, from_now=False)
    assert own.silence == ""
    assert OwnCommands(one_sample(), lambda _: None, one_per_sample=False).silence == ""
