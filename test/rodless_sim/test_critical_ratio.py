# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The critical pressure ratio follows the isentropic index where it is not given."""

import pytest

from rodless_sim import ParameterError, RigParameters

INDEX, RATIO = "air.isentropic_index", "air.critical_ratio"

# Textbook values of p*/p0 (Anderson, Modern Compressible Flow).
BOOK = {1.3: 0.5457, 1.4: 0.5283, 1.667: 0.4871}


@pytest.mark.parametrize("index", [1.3, 1.667])
def test_a_gas_needs_its_index_only(index: float) -> None:
    """In a new set and in a changed one."""
    for found in (RigParameters({INDEX: index}), RigParameters().with_values({INDEX: index})):
        assert found[RATIO] == pytest.approx(BOOK[index], abs=1e-4)


def test_back_to_air() -> None:
    """The ratio comes back with the index, to the digits of the paper's."""
    found = RigParameters({INDEX: 1.3}).with_values({INDEX: 1.4})
    assert found[RATIO] == pytest.approx(BOOK[1.4], abs=1e-4)


def test_a_ratio_that_fits_stays() -> None:
    """The paper's 0.528 is rounded and no number changes."""
    assert RigParameters({INDEX: 1.4})[RATIO] == 0.528
    assert RigParameters().with_values({"supply.pressure": 6e5})[RATIO] == 0.528


def test_a_ratio_that_is_given_is_checked() -> None:
    """What is said is not changed in silence."""
    with pytest.raises(ParameterError, match=r"air\.critical_ratio: 0\.528 refused"):
        RigParameters({INDEX: 1.3, RATIO: 0.528})
    with pytest.raises(ParameterError, match=r"air\.critical_ratio: 0\.6 refused"):
        RigParameters({INDEX: 1.3}).with_values({RATIO: 0.6})
