# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Samples missing from a recording are told from samples that came late."""

import numpy as np
from hypothesis import given
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
    """Up to nine samples in ten, by chance, with stamps that came twice among the rest."""
    generator = np.random.default_rng(seed)
    there = generator.random(EVEN.shape) >= share
    there[[0, 1, -1]] = True
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


def test_stamps_that_tell_nothing_are_passed_over() -> None:
    """Zeros, as a publisher without a clock leaves them, and topics of one message or none."""
    assert missing_samples({"/a": np.zeros(9), "/b": np.empty(0), "/c": EVEN[:1]}) == ""
