# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless tune`: the parameters of a law that score best over many rigs, as a parameter file."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from rodless_base.atomic_write import check_files_writable, named_or_as_it_is
from rodless_base.command_line import Parser, named_path
from rodless_base.start import Stop
from rodless_lab.cli.overwriting import check_none_is_read
from rodless_lab.cli.progress import Progress

FOLDER = Path("results/tuning")


def main(arguments: Sequence[str], stop: Stop) -> int:
    """Return 0 once the search is over, 1 after Ctrl-C, 2 for a bad task."""
    options = _parsed(arguments)
    stop.from_now_on_wait(impatient=True)
    try:
        return _tune(options, stop)
    except ValueError as error:
        print(error, file=sys.stderr)
        return 2
    except OSError as error:
        print(named_or_as_it_is(error), file=sys.stderr)
        return 2


def _tune(options: argparse.Namespace, stop: Stop) -> int:
    # They load numba: not for help.
    from rodless_lab.studies.files_read import files_read  # noqa: PLC0415
    from rodless_lab.studies.tune import NothingKnownError, search  # noqa: PLC0415
    from rodless_lab.studies.tuning_report import PARAMETERS, result_files, write_tuned  # noqa: PLC0415
    from rodless_lab.studies.tuning_task import read_task  # noqa: PLC0415

    task = read_task(options.task)
    folder = options.output or FOLDER / task.name
    check_none_is_read(result_files(folder), files_read("tasks", options.task, "the task"))
    for name, value in task.outside().items():
        one = task.ranges[name]
        print(
            f"{name}: {value:g} in force is outside of {one.low:g} to {one.high:g}; "
            "the search begins at the nearer end",
            file=sys.stderr,
        )
    check_files_writable(result_files(folder))
    try:
        found = search(task, folder, Progress().show, lambda: stop.requested)
    except NothingKnownError as error:
        print(error, file=sys.stderr)
        return 1
    print(write_tuned(folder, task, found))
    print(
        f"written to {folder / PARAMETERS}; for `rodless rig --parameters`, or the controller's "
        "--params-file"
    )
    if found.complete and found.converged:
        print(
            f"the search has converged: the last of {len(found.candidates)} candidates score alike"
        )
    if not found.complete:
        print("interrupted: the best so far; the same command goes on", file=sys.stderr)
        return 1
    return 0


def _parsed(arguments: Sequence[str]) -> argparse.Namespace:
    parser = Parser(
        prog="rodless tune",
        description="Look for the parameters of a law that score best over many rigs, and write "
        "them as a parameter file. See docs/tuning.md.",
        epilog="Ctrl-C interrupts it and writes the best so far; the same command goes on. Exit "
        "code: 0 the search is over; 1 Ctrl-C; 2 a task or folder that cannot be used.",
    )
    parser.add_argument("task", metavar="TASK", help="a YAML file, or a task that ships: pid")
    parser.add_argument("-o", "--output", type=named_path, help=f"folder (default: {FOLDER}/TASK)")
    return parser.parse_args(arguments)
