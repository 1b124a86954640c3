# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Which messages of a topic have not come, where each publisher counts its own."""

# Publishers that may take turns on a topic; of more, those that are lowest in number are forgotten.
REMEMBERED = 16


class PublisherCounters:
    """The last number of each publisher of a topic: who it is does not come with a message.

    :attr:`turns` counts numbers that go back: another publisher has its turn, now and then one
    started again.
    """

    def __init__(self) -> None:
        """Nothing has come."""
        # In the order in which they were last heard.
        self._last: dict[int, None] = {}
        self._previous = 0
        self.turns = 0

    def take(self, number: int) -> int:
        """Take a message's ``number``, from 1 on, 0 for unknown; return how many before it missed.

        They are counted for the publisher whose last number is the nearest below; of one that
        begins none is missed. One that is first heard in its midst and above another's last number
        is taken for that one.
        """
        self.turns += 0 < number <= self._previous
        self._previous = number
        before = max((last for last in self._last if last < number), default=0)
        self._last.pop(before, None)
        self._last.pop(number, None)
        self._last[number] = None
        if len(self._last) > REMEMBERED:
            del self._last[next(iter(self._last))]
        return number - before - 1 if before else 0
