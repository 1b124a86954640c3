# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The errata as numbers: complete against the errata page, and their limits bite."""

import re
from pathlib import Path

import pytest

from rodless_lab.experiments.errata import ErrataResult, run_errata

PAGE = Path(__file__).resolve().parents[3] / "docs" / "errata.md"


@pytest.fixture(scope="module")
def result() -> ErrataResult:
    """Return all rows."""
    return run_errata()


def errata_rows() -> list[str]:
    """First cells of the errata table: where the fault is."""
    lines = PAGE.read_text(encoding="utf-8").splitlines()
    return [line.split("|")[1].strip() for line in lines if line.startswith("| ")][1:]


@pytest.mark.parametrize("where", errata_rows())
def test_every_erratum_has_a_number_or_a_word_why_not(where: str, result: ErrataResult) -> None:
    """Each equation that the errata page names is among the rows, or said to have none."""
    told = " ".join([*(row.quantity for row in result.comparisons), *result.remarks])
    first = re.findall(r"\(\d+\)|Table \d|5\.08 V|section 7|x_v|^R\b", where)
    assert first
    assert any(name in told if name != "R" else "R: speed of sound" in told for name in first)


def test_limits_refuse_what_is_printed(result: ErrataResult) -> None:
    """Where the paper's column starts with a number, that number lies outside the limits.

    Eq. (26) is kept as printed, and a factor over the printed form is 1 for itself.
    """
    checked = 0
    for row in result.comparisons:
        printed = re.match(r"-?\d+(\.\d+)?(?! ·)", row.paper)
        if printed is None or row.quantity.startswith("(26)"):
            continue
        assert row.limits is not None
        assert not row.limits.lowest <= float(printed[0]) <= row.limits.highest, row.quantity
        checked += 1
    assert checked >= 10
