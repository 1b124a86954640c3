# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What a plant in lock-step waits for: an answer to each of its offers of a sample."""

from rodless_lab.session.samples import Cursor, Received


class Offers(Cursor):
    """Reads the samples in order, and how many answers to each are still to be given.

    The plant counts them: where it has offered a sample again, and be it of a run that was reset
    meanwhile, one answer less or more would set all that follow one sample apart.
    """

    def __init__(self, received: Received) -> None:
        """As a cursor; nothing has been answered."""
        super().__init__(received)
        self._answered: tuple[int, int] | None = None  # run and index of the last sample
        self._times = 0  # how often it was

    def begin(self, run: int) -> None:
        """Go on with the first sample of a run, of a plant that was started anew."""
        super().begin(run)
        self._answered = None

    def skip(self) -> None:
        """Take the next sample for answered, once."""
        place = self._place()
        if place is not None:
            self._answered, self._times = place, 1
        super().skip()

    @property
    def again(self) -> int:
        """How many further answers are due to the sample that was answered last."""
        return self._offers(self._answered) - self._times if self._answered is not None else 0

    def answer_again(self) -> None:
        """Take one of these for given."""
        self._times += 1

    @property
    def due(self) -> int:
        """How many answers are due in all."""
        place = self._place()
        return self.again + (self._offers(place) if place is not None else 0)

    def is_due_before(self, run: int) -> bool:
        """Whether a sample of a run before this one waits for its first answer."""
        place = self._place()
        return place is not None and place[0] < run

    def _offers(self, place: tuple[int, int]) -> int:
        return 1 + self._received.joint.offered_again[place]
