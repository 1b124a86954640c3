# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""When the step of a demo began, told from its bag."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from rodless_lab.demo import TARGET, step_time


@dataclass
class Messages:
    """What a bag tells of a topic."""

    stamp: Any
    reference: Any

    @property
    def time(self) -> Any:
        """Log times in s."""
        return self.stamp

    @property
    def fields(self) -> dict[str, Any]:
        """The only field."""
        return {"data": self.reference}

    def __len__(self) -> int:
        return len(self.stamp)


def begin(samples: list[float], answered: list[float]) -> float:
    """Return the step's time, of references that hold the target from 3 ms on."""
    stamps = np.array(answered)
    bag: Any = {
        "/joint_states": Messages(np.array(samples), None),
        "/controller/reference": Messages(stamps, np.where(stamps < 3e-3, 0.0, TARGET)),
    }
    return step_time(bag)


ONCE = [0.0, 1e-3, 2e-3, 3e-3, 4e-3, 5e-3]


@pytest.mark.parametrize(
    ("samples", "answered"),
    [
        (ONCE, ONCE),
        ([0.0, *ONCE], ONCE),
        ([0.0, *ONCE], [0.0, *ONCE]),
        ([*ONCE[:3], *ONCE[2:]], ONCE),
    ],
)
def test_a_sample_that_was_offered_twice_counts_once(
    samples: list[float], answered: list[float]
) -> None:
    """Whether the controller answered it once or twice; a crowded machine makes it wait so long."""
    assert begin(samples, answered) == 3e-3


def test_a_bag_with_fewer_references_than_samples_is_refused() -> None:
    """Nobody could say which sample the first answer with the target belongs to."""
    with pytest.raises(RuntimeError, match="is incomplete"):
        begin(ONCE, ONCE[3:])
    with pytest.raises(RuntimeError, match="has not taken the set-point"):
        begin(ONCE, ONCE[:3])
