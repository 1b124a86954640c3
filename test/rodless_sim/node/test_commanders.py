# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Who commands a lock-step plant: what is owed, and whether there may be another."""

import pytest

from rodless_base.ros.publish import UNKNOWN
from rodless_sim.node.commanders import Account, Crowd, share_a_node

ONE, ANEW, OTHER = b"participant1 pub 1", b"participant1 pub 2", b"participant2 pub 1"


def test_numbers_count_the_answers_that_were_lost() -> None:
    """Five offers, answers 1, 2 and 4: one is still owed; more than are owed leave none."""
    account = Account()
    for _ in range(5):
        account.offer()
    owed = []
    for number in (1, 2, 4, 9):
        account.take(number)
        owed.append(account.owed)
    assert owed == [4, 3, 1, 0]
    account.offer()
    assert (account.owed, account.last) == (1, 9)
    assert [account.is_due(number) for number in (9, 10, 11)] == [False, True, False]


@pytest.mark.parametrize(
    ("publisher", "name", "same"),
    [
        (ANEW, "/b", True),
        (ANEW, UNKNOWN, True),
        (ANEW, "/a", False),
        (ANEW, "/c", False),
        (OTHER, "/b", False),
        (OTHER, UNKNOWN, False),
    ],
)
def test_a_node_is_known_by_its_participant_and_its_name(
    publisher: bytes, name: str, same: bool
) -> None:
    """As long as the name is not known, by the participant alone; either way round."""
    assert share_a_node({ONE: "/b"}, {publisher: name}) is same
    assert share_a_node({publisher: name}, {ONE: "/b"}) is same


def test_a_name_that_is_told_late_makes_no_crowd() -> None:
    """One comes unseen and goes; that it is named afterwards brings nobody."""
    crowd, known = Crowd(lambda: 1, lambda: 0.0), {ONE: "/b"}
    crowd.connect(2)
    assert crowd.look(known, known)
    for _ in range(2):
        crowd.poll(known, known)
    assert not crowd.is_here
    assert not crowd.look({OTHER: "/b"}, known)
