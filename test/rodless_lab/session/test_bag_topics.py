# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A session's bag of topics that nobody publishes."""

from pathlib import Path

import pytest
from extent import extensive

from rodless_lab.bags.reader import Bag
from rodless_lab.harness import RigSession, WaitTimeoutError


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


def test_a_bag_says_where_it_is_and_what_it_holds() -> None:
    """Also an empty one."""
    assert repr(Bag(Path("run1"), {}, complete=True)) == "<Bag run1: no topics>"
    assert repr(Bag(Path("run1"), {}, complete=False)) == "<Bag run1, incomplete: no topics>"
