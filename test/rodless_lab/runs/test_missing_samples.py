# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Samples missing from a recording are told from samples that came late."""

import re

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from rodless_lab.runs.missing_samples import missing_samples

EVEN = np.arange(1000) * 1e-3


@given(st.sets(st.integers(1, 998), min_size=1, max_size=200))
def test_what_was_taken_out_is_counted(lost: set[int]) -> None:
    """Any samples but the ends', alone or in a row, from an even second of 1 kHz."""
    kept = np.delete(EVEN, sorted(lost))
    assert missing_samples({"/whole": EVEN, "/cut": kept}) == (
        f"samples are missing, from {EVEN[min(lost) - 1]:.3f} s on: {len(lost)} of 1000 of /cut"
    )


@given(st.integers(0, 2**32 - 1), st.floats(0.01, 0.9))
def test_heavy_losses_are_counted(seed: int, share: float) -> None:
    """Up to nine samples in ten, by chance, with stamps that came twice among the rest.

    One in twenty of those that are left, and one more, follow the one before, as the method wants.
    """
    generator = np.random.default_rng(seed)
    there = generator.random(EVEN.shape) >= share
    there[[0, 1, -1]] = True
    apart = np.diff(np.flatnonzero(there))
    assume(np.sum(apart == 1) > 0.05 * len(apart))
    kept = np.sort(np.concatenate([EVEN[there], EVEN[there][:10]]))
    found = missing_samples({"/cut": kept})
    assert found.endswith(f": {np.sum(~there)} of 1000 of /cut") == (not there.all())


@given(st.integers(0, 2**32 - 1))
def test_late_samples_are_not_missing(seed: int) -> None:
    """Stamps of a real rig's driver: a few much too late, or all with jitter to 0.9 periods."""
    generator = np.random.default_rng(seed)
    jitter = generator.uniform(0.0, 0.9e-3, EVEN.shape)
    late = np.where(generator.random(EVEN.shape) < 0.004, 0.9e-3, 0.0) + 0.05 * jitter
    late[-1] = 0.0
    stamps = {"/jitter": 0.97 * EVEN + jitter, "/late": 0.97 * EVEN + late}
    assert missing_samples(stamps) == ""


@pytest.mark.parametrize(
    ("kept", "said"),
    [
        (EVEN[:500], "from 0.499 s on: 500 of 1000 of /cut, which ends 0.500 s early"),
        (EVEN[400:], "from its start on: 400 of 1000 of /cut, which begins 0.400 s late"),
        (
            EVEN[400:600],
            "from its start on: 800 of 1000 of /cut, which begins 0.400 s late and ends 0.400 s ea",
        ),
        (
            np.delete(EVEN[:500], 200),
            "from 0.199 s on: 501 of 1000 of /cut, which ends 0.500 s early",
        ),
        (EVEN[:500:100], "from 0.400 s on: 6 of 11 of /cut, which ends 0.599 s early"),
    ],
    ids=["end", "start", "both", "between too", "a slow topic"],
)
@pytest.mark.parametrize("begin", [0.0, 0.4], ids=["whole", "from where all are there"])
def test_a_topic_that_ends_before_the_others_lacks_the_rest(
    kept: npt.NDArray[np.float64], said: str, begin: float
) -> None:
    """Its name, how many samples, and how early it ends, or how late it begins."""
    late = begin and kept[0] > 0.0
    found = missing_samples({"/whole": EVEN - late * begin, "/cut": kept - late * begin})
    if not late:
        said = said.replace("from its start", "from 0.000 s")
    assert found.startswith(f"samples are missing, {said}")


def test_topics_with_jitter_that_end_early_are_told_too() -> None:
    """How many are missing in between nobody can say of them, beyond the end all can."""
    jitter = np.random.default_rng(2).uniform(0.0, 0.9e-3, EVEN.shape)
    found = missing_samples({"/whole": EVEN, "/cut": (EVEN + jitter)[:500]})
    (lost, asked) = re.findall(r"(\d+) of (\d+) of /cut, which ends 0\.500 s early$", found)[0]
    assert (int(lost), int(asked)) == pytest.approx((500, 1000), abs=1)


def test_a_fast_plant_ends_its_topics_as_many_times_further_apart() -> None:
    """What a recorder loses takes wall-clock time: at ten times that, a second of 1.0 is told."""
    stamps = {"/whole": 10.0 * EVEN, "/cut": 10.0 * EVEN[:950]}
    assert missing_samples(stamps, pace=10.0) == ""
    assert "50 of 1000 of /cut, which ends 0.500 s early" in missing_samples(stamps)
    stamps["/cut"] = stamps["/cut"][:850]
    assert "150 of 1000 of /cut, which ends 1.500 s" in missing_samples(stamps, pace=10.0)


@given(st.integers(0, 90), st.integers(0, 290))
def test_ragged_ends_of_a_recorder_are_no_loss(early: int, late: int) -> None:
    """Ctrl-C and discovery do not come to all topics at one time; nor has a slow one the last."""
    slow = np.arange(-1.0, 0.95, 0.2)
    assert missing_samples({"/whole": EVEN, "/cut": EVEN[late : 1000 - early]}) == ""
    assert missing_samples({"/whole": np.arange(-1.0, 1.0, 1e-3), "/slow": slow}) == ""


def test_what_is_missing_before_the_run_is_missing_from_its_start_on() -> None:
    """Stamps count from the last topic's beginning: no time in a message is negative."""
    stamps = np.delete(EVEN, 2) - 3e-3
    assert missing_samples({"/early": stamps}) == (
        "samples are missing, from its start on: 1 of 1000 of /early"
    )
    assert "from 0.000 s on" in missing_samples({"/early": np.delete(EVEN, 4) - EVEN[3] - 1e-12})


def test_stamps_that_tell_nothing_are_passed_over() -> None:
    """Zeros, as a publisher without a clock leaves them, and topics of one message or none."""
    assert missing_samples({"/a": np.zeros(9), "/b": np.empty(0), "/c": EVEN[:1]}) == ""
