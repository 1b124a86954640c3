# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""How far two runs are apart: a table, a picture, and the numbers as JSON."""

import json
from collections.abc import Mapping
from pathlib import Path

from rodless_base.atomic_write import check_files_writable, check_writable, write_together
from rodless_lab.figures.comparison import Array, draw_comparison
from rodless_lab.figures.files import png
from rodless_lab.runs.comparison import QUANTITIES, Difference
from rodless_lab.runs.measured_run import MeasuredRun

# What is said of results that have replaced earlier ones.
IN_PLACE = ", in place of earlier ones"

Pair = tuple[MeasuredRun, MeasuredRun]


def write_differences(
    file: Path, names: tuple[str, str], runs: Pair, time: Array, numbers: Mapping[str, object]
) -> bool:
    """Write the picture of both runs as ``FILE.png`` and ``numbers`` as ``FILE.json``.

    ``time`` (s, shape (n,)) is where they are compared. Returns whether earlier ones were there,
    which these replace. Raises OSError.
    """
    picture, table = difference_files(file)
    replaced = table.exists()
    text = json.dumps(numbers, indent=2) + "\n"
    write_together({picture: png(lambda: draw_comparison(names, runs, time)), table: text})
    return replaced


def check_differences_writable(file: Path) -> None:
    """Raise OSError where :func:`write_differences` could not write."""
    check_writable(file.parent)
    check_files_writable(difference_files(file))


def difference_files(file: Path) -> tuple[Path, Path]:
    """Return where :func:`write_differences` writes."""
    return file.with_suffix(".png"), file.with_suffix(".json")


def differences_table(names: tuple[str, str], found: Mapping[str, Difference]) -> str:
    """Return the differences as a table for people."""
    lines = [
        f"{names[1]} minus {names[0]}",
        f"{'':16}{'steady state':>16}{'largest':>14}{'at':>10}{'rms':>12}",
    ]
    for name, value in found.items():
        label, unit, factor = QUANTITIES[name]
        lines.append(
            f"{label:16}{value.steady * factor:16.3f}{value.largest * factor:14.3f}"
            f"{value.time:8.3f} s{value.rms * factor:12.3f} {unit}"
        )
    return "\n".join(lines)
