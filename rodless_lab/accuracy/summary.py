# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A campaign in two tables: percentiles of the errors, and the worst cases with what explains them.

A rig that magnifies differences magnifies the integrator's too: there no method is more exact than
the disturbance that its own error stands for.
"""

import math
from collections import Counter
from collections.abc import Sequence

import numpy as np

from rodless_lab.accuracy.judge import DISTURBANCE, NOISE, Verdict

PERCENTS = (50.0, 95.0, 99.0, 99.9, 100.0)
MICROMETRES = 1e6
WORST = 12
# An error counts as explained where the disturbance does at least this share of it.
EXPLAINED = 0.1
LARGE = 5e-6  # m


def summary(verdicts: Sequence[Verdict]) -> str:
    """Return both tables and the counts as Markdown."""
    ran = [verdict for verdict in verdicts if math.isfinite(verdict.position)]
    return "\n".join(
        [*_percentiles(ran), "", *_counts(verdicts, ran), "", *_radau(ran), "", *_worst(ran), ""]
    )


def _percentiles(ran: Sequence[Verdict]) -> list[str]:
    heads = [f"{percent:g} %" for percent in PERCENTS[:-1]] + ["worst"]
    lines = [
        "| rigs | number | moved | " + " | ".join(heads) + " | pressure, 99 % |",
        "|---|---|---|" + "---|" * (len(heads) + 1),
    ]
    groups = sorted({(v.around, v.drive) for v in ran}, key=lambda g: (g[1] != "open loop", g[0]))
    for around, drive in groups:
        group = [v for v in ran if (v.around, v.drive) == (around, drive)]
        errors = np.percentile([v.position for v in group], PERCENTS) * MICROMETRES
        moved = np.mean([v.travel > 1e-4 for v in group])
        pressure = np.percentile([v.pressure for v in group], 99.0)
        figures = " | ".join(f"{error:.2g} µm" for error in errors)
        lines.append(
            f"| {around}, {drive} | {len(group)} | {moved:.0%} | {figures} | {pressure:.2g} Pa |"
        )
    return lines


def _counts(verdicts: Sequence[Verdict], ran: Sequence[Verdict]) -> list[str]:
    failed = [verdict for verdict in verdicts if not math.isfinite(verdict.position)]
    large = [verdict for verdict in ran if verdict.position > LARGE]
    explained = sum(v.disturbed_position > EXPLAINED * v.position for v in large)
    return [
        f"{len(verdicts)} rigs, {len(failed)} not computed. {len(large)} errors above "
        f"{LARGE * MICROMETRES:g} µm, {len([v for v in large if v.drive == 'open loop'])} of them "
        f"in open loop; in {explained} of them {DISTURBANCE:g} Pa of supply and {NOISE * 1e9:g} nm "
        f"of sensor noise change the converged run by more than {EXPLAINED:.0%} of the error.",
        *(f"- rig {verdict.number}: {verdict.failure}" for verdict in failed[:WORST]),
    ]


def _radau(ran: Sequence[Verdict]) -> list[str]:
    solved = [verdict for verdict in ran if math.isfinite(verdict.radau_position)]
    # It may take too long, and it may find no step that is small enough.
    failures = Counter(verdict.failure for verdict in ran if verdict.failure).most_common()
    reasons = [f"- {count} not solved by {failure}" for failure, count in failures]
    if not solved:
        return ["No rig was solved by Radau.", *reasons]
    away = np.percentile([v.radau_position for v in solved], PERCENTS) * MICROMETRES
    figures = ", ".join(f"{p:g} %: {error:.2g} µm" for p, error in zip(PERCENTS, away, strict=True))
    return [
        f"{len(solved)} rigs solved by Radau at 1e-10 too. "
        f"The converged run is away from it by {figures}.",
        *reasons,
    ]


def _worst(ran: Sequence[Verdict]) -> list[str]:
    worst = sorted(ran, key=lambda verdict: -verdict.position)[:WORST]
    return [
        "| rig | | error | disturbed | travel |",
        "|---|---|---|---|---|",
        *(
            f"| {v.number} | {v.around}, {v.drive} | {v.position * MICROMETRES:.3g} µm | "
            f"{v.disturbed_position * MICROMETRES:.3g} µm | {v.travel * 1e3:.3g} mm |"
            for v in worst
        ),
    ]
