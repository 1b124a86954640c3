# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Whether a law can be broken off: while one is made or called, and not else."""

from rodless_control.law_calls import LawCalls


def test_a_law_that_makes_another_one_can_be_broken_off_behind_it() -> None:
    """The other is made; the first, which goes on, may still not return."""
    with LawCalls.making():
        with LawCalls.making():
            assert LawCalls.under_way
        assert LawCalls.under_way
    assert not LawCalls.under_way
