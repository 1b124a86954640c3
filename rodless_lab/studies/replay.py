# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""One row of a sweep once more: in process, and over the nodes in lock-step."""

from pathlib import Path
from typing import Any

import numpy as np

from rodless_lab.simulation.closed_loop import ClosedLoopTrace
from rodless_lab.simulation.run_metrics import RunMetrics
from rodless_lab.studies.errors import StudyError
from rodless_lab.studies.part import TRACE
from rodless_lab.studies.parts import Parts
from rodless_lab.studies.row_run import RowRunner
from rodless_lab.studies.saved_study import read_saved_study
from rodless_lab.studies.study import Row, Study

# What the nodes publish of a run.
PUBLISHED = ("position", "velocity", "pressure_a", "pressure_b", "voltage", "force")


def replay_row(folder: Path, number: int, ros: bool = False) -> list[str]:
    """Run a row of a sweep again and say in what it differs: nothing, if all is well.

    Raises StudyError for a folder without a sweep or a row that it does not have, and with ``ros``
    for a row that fails; OSError for a folder that cannot be read, and with ``ros`` RuntimeError
    where the nodes fail.
    """
    study = read_saved_study(folder)
    if not 0 <= number < len(study):
        raise StudyError(f"row {number} refused: {folder} has rows 0 to {len(study) - 1}")
    saved = _saved(folder, study, number)
    if ros and saved["failure"]:
        raise StudyError(
            f"row {number} refused: its run fails ({saved['failure']}), and the nodes go on; "
            "replay it without --ros"
        )
    row = study.row(number)
    found = RowRunner(study.trace_columns, study.trace_every)(row)
    differences = [
        _line(name, saved[name], value)
        for name, value in zip(RunMetrics._fields, found.metrics, strict=True)
        if not _same(saved[name], value)
    ]
    if saved["failure"] != found.failure:
        differences.append(_line("failure", saved["failure"], found.failure))
    for name in study.trace_columns:
        if not np.array_equal(saved[TRACE + name], found.traces.get(name, []), equal_nan=True):
            differences.append(f"{TRACE}{name}: not the same numbers")
    if ros and not found.failure:
        differences += _over_ros(row)
    return differences


def _saved(folder: Path, study: Study, number: int) -> dict[str, Any]:
    parts = Parts(folder, study)
    part = parts.of(number)
    if not parts.is_complete(part):
        raise StudyError(f"{folder}: row {number} is not known yet; run the sweep on first")
    (row,) = parts.read(part).slice(number - parts.rows(part).start, 1).to_pylist()
    return dict(row)


def _same(one: float, other: float) -> bool:
    return bool(np.array_equal([one], [other], equal_nan=True))


def _line(name: str, saved: object, found: object) -> str:
    return f"{name}: {saved!r} in the data set, {found!r} now"


def _over_ros(row: Row) -> list[str]:
    """Say in what a run of the nodes differs from one in process."""
    from rodless_lab.experiments.ros_runner import nodes_runner  # noqa: PLC0415  needs ROS

    base = row.base
    here = base.loop()
    expected = here.traced(here.run(base.rig))
    over_dds = nodes_runner().closed_loop(
        base.rig, base.controller, base.reference, base.duration, base.period
    )
    return [
        f"{name}: differs from sample {_first_difference(expected, over_dds, name)} on"
        for name in PUBLISHED
        if not np.array_equal(getattr(expected, name), getattr(over_dds, name))
    ]


def _first_difference(one: ClosedLoopTrace, other: ClosedLoopTrace, name: str) -> int:
    first, second = getattr(one, name), getattr(other, name)
    common = min(len(first), len(second))
    apart = np.flatnonzero(first[:common] != second[:common])
    return int(apart[0]) if apart.size else common
