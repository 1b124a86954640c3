# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Write what was identified as a ROS parameter file that the plant loads."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from rodless_base.yaml_file import yaml_text
from rodless_lab.identification.estimate import Estimate
from rodless_lab.runs.measured_run import MeasuredRun
from rodless_sim import RigParameters

SECTION = "/**/plant"

# How the first line of such a file begins.
_TITLE = "Identified by `rodless identify"


@dataclass(frozen=True)
class Finding:
    """A parameter's new value with the estimates behind it, by what they are called.

    ``value`` is ``None`` where the data does not inform it: the file then says so and leaves the
    parameter at its default. A choice that goes with other findings has no estimates of its own.
    """

    name: str
    value: float | tuple[float, ...] | str | None
    estimates: Mapping[str, Estimate]


def title(subject: str, bag: str, run: MeasuredRun, sensors: str, base: str) -> list[str]:
    """Say what was identified, from what, and what was taken as known."""
    return [
        f"{_TITLE} {subject}` from {bag}: {run.time[-1]:.1f} s, {len(run.time)} samples.",
        f"Intervals are 95 % confidence intervals; sensors: {sensors}; taken as known: {base}.",
    ]


def identified_subject(file: Path) -> str:
    """Return what a parameter file was identified for, ``""`` if it was not; raises OSError."""
    _, found, rest = file.read_text(encoding="utf-8").partition(f"# {_TITLE} ")
    return rest.partition("`")[0] if found else ""


def findings_table(findings: Sequence[Finding]) -> str:
    """Return the findings as lines for people."""
    lines = []
    for found in findings:
        for label, estimate in found.estimates.items():
            shown = str(estimate) if found.value is not None else estimate.note
            note = f"  [{estimate.note}]" if found.value is not None and estimate.note else ""
            # Of one estimate the parameter's own name says it all.
            which = "" if label == found.name else f"{label:10} "
            lines.append(f"{found.name:34} {which}{shown}{note}")
    return "\n".join(lines)


def parameter_text(heading: Sequence[str], findings: Sequence[Finding]) -> str:
    """Return the file's text: values, with intervals as comments; raises ParameterError.

    The values are checked as the plant checks them when it loads the file.
    """
    informed = {found.name: found.value for found in findings if found.value is not None}
    RigParameters(informed)
    lines = [f"# {line}".rstrip() for line in heading]
    lines += [f"{SECTION}:", "  ros__parameters:" + ("" if informed else " {}")]
    for found in findings:
        lines += _entry(found)
    return "\n".join(lines) + "\n"


def _entry(found: Finding) -> list[str]:
    comments = []
    for label, estimate in found.estimates.items():
        if found.value is None:
            comments.append(f"    # {found.name}: {estimate.note or 'not informed'}")
            continue
        unit = f" {estimate.unit}" if estimate.unit else ""
        line = f"    # {label}: 95 % from {estimate.low:.6g} to {estimate.high:.6g}{unit}"
        comments.append(line if not estimate.note else f"{line}; {estimate.note}")
    if found.value is None:
        return comments
    return [*comments, f"    {found.name}: {yaml_text(_rounded(found.value))}"]


def _rounded(value: float | tuple[float, ...] | str) -> float | tuple[float, ...] | str:
    if isinstance(value, str):
        return value
    if isinstance(value, tuple):
        return tuple(float(f"{item:.9g}") for item in value)
    return float(f"{value:.9g}")
