# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What a soak has shown, as Markdown, and what of it is not as it should be."""

import math
from typing import Protocol

from rodless_lab.soak.balance import Balance

# Memory that grows faster than this, in MB/h, is a leak. Only long runs can tell.
LEAK = 5.0
LONG_ENOUGH = 600.0  # s

# A balance that does not close by more than this share of the turnover: at 1 kHz flows bend within
# a period by some 1e-7 of it.
GAP = 1e-5


class Soaked(Protocol):
    """What :class:`rodless_lab.soak.ros.soak.Soak` holds."""

    mode: str
    seconds: float
    samples: int
    lost: int
    differing: int
    faults: dict[str, str]
    balance: Balance | None

    @property
    def growth(self) -> dict[str, float]:
        """How fast the memory of each process grows, in MB/h."""

    @property
    def memory(self) -> dict[str, list[tuple[float, float]]]:
        """Memory of each process: s, MB."""


def complaints(run: Soaked) -> list[str]:
    """Return what is not as it should be, a line each."""
    found = []
    if run.lost:
        found.append(f"{run.mode}: {run.lost} of {run.samples} samples lost")
    if run.differing:
        found.append(f"{run.mode}: {run.differing} samples differ from the run without nodes")
    if run.balance is not None and not run.balance.gap < GAP:
        found.append(f"{run.mode}: the balance does not close: {run.balance.gap:.2g} of turnover")
    for name, slope in run.growth.items():
        if run.seconds >= LONG_ENOUGH and slope > LEAK:
            found.append(f"{run.mode}: memory of the {name} grows by {slope:.1f} MB/h")
    return found


def summary(run: Soaked) -> str:
    """Return one run as a table."""
    rows = [
        ("wall clock", f"{run.seconds:.0f} s"),
        ("samples", f"{run.samples}"),
        ("lost", f"{run.lost}"),
    ]
    if run.balance is not None:
        rows += [
            ("other than without nodes", f"{run.differing}"),
            ("enthalpy in and out", f"{run.balance.turnover:.4g} J"),
            ("balance open by", f"{run.balance.gap:.2g} of that"),
        ]
    for name, readings in run.memory.items():
        slope = run.growth[name]
        grows = "too short to tell" if math.isnan(slope) else f"{slope:+.2f} MB/h"
        rows.append((f"memory of the {name}", f"{readings[-1][1]:.1f} MB, {grows}"))
    rows += [(name, value) for name, value in run.faults.items() if value != "0"]
    table = [f"| {name} | {value} |" for name, value in rows]
    return "\n".join([f"| {run.mode} | |", "|---|---|", *table])
