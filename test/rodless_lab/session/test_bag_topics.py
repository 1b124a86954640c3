# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A session's bag, also of topics that nobody publishes, and of a session that goes wrong."""

import time
from pathlib import Path

import pytest
from extent import extensive

from rodless_lab.bags.reader import Bag, read_bag
from rodless_lab.harness import RigSession, WaitTimeoutError
from rodless_lab.session import bag as session_bag
from rodless_lab.session.bag import SessionBag
from rodless_lab.session.observer import Observer
from rodless_lab.session.samples import LostSampleError, Stamped


@extensive
def test_a_topic_that_nobody_publishes_is_named(tmp_path: Path, compiled: None) -> None:  # noqa: ARG001
    """The wait for it ends with its name and what to do."""
    session = RigSession(bag=tmp_path / "bag", bag_topics=["no/such/topic"], timeout=30.0)
    with pytest.raises(WaitTimeoutError, match=r"^nobody publishes /no/such/topic; take it out of"):
        session.__enter__()
    assert not (tmp_path / "bag").exists()


def test_a_session_that_does_not_start_leaves_no_bag(tmp_path: Path) -> None:
    """The next try under the same name is not refused for it, and no folder is left.

    Also where the faults in force have been recorded, which are told before the run.
    """
    bag = tmp_path / "new" / "bag"

    def check() -> None:
        if session._bag is not None and session._bag._recorder.received["/faults"]:
            raise LookupError("enough")

    session = RigSession(bag=bag, bag_topics=["no/such/topic"], check=check)
    with pytest.raises(LookupError, match="enough"):
        session.__enter__()
    assert list(tmp_path.iterdir()) == []


def test_a_bag_that_is_behind_is_waited_for_as_long_as_it_goes_on(
    tmp_path: Path, domain: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ten commands come later in all than one may; the eleventh does not come, and that is said."""
    every = 0.1
    monkeypatch.setattr(session_bag, "CATCH_UP_TIMEOUT", 5.0 * every)
    with Observer(domain) as observer:
        bag = SessionBag(tmp_path / "bag", [], observer)
        commands = bag._recorder.received
        topic = bag._recorder.node.resolve_topic_name("valve/voltage")

        def come() -> None:
            commands[topic] = min(commands[topic] + 1, 10)

        observer.node.create_timer(every, come)
        try:
            bag.catch_up(10)
            with pytest.raises(LostSampleError, match="the bag lacks commands"):
                bag.catch_up(11)
        finally:
            bag.close(has_begun=False)


def test_a_session_that_loses_samples_ends_its_bag(tmp_path: Path) -> None:
    """As where somebody else publishes a sample of the start: the run is torn, the bag opens."""
    bag = tmp_path / "bag"

    def run_and_tear() -> None:
        with RigSession("lockstep", bag=bag) as rig:
            rig.run_for(0.2)
            rig._received.joint.put(Stamped(time.time_ns(), 0, (0.0, 0.0, 0.0)))
            rig.run_for(1.0)

    with pytest.raises(LostSampleError):
        run_and_tear()
    found = read_bag(bag)
    assert found.complete
    assert len(found["/joint_states"].log_time) > 200


def test_a_bag_says_where_it_is_and_what_it_holds() -> None:
    """Also an empty one."""
    assert repr(Bag(Path("run1"), {}, complete=True)) == "<Bag run1: no topics>"
    assert repr(Bag(Path("run1"), {}, complete=False)) == "<Bag run1, incomplete: no topics>"
