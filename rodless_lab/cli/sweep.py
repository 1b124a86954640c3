# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless sweep`: many runs over parameters of rig, law and task, into one Parquet data set."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from rodless_base.atomic_write import check_files_writable, named_or_as_it_is
from rodless_base.command_line import Parser, named_path
from rodless_base.start import Stop
from rodless_lab.cli.number import whole
from rodless_lab.cli.overwriting import check_none_is_read
from rodless_lab.cli.progress import Progress

FOLDER = Path("results/sweeps")


def main(arguments: Sequence[str], stop: Stop) -> int:
    """Return 0 if all rows are known, 1 after Ctrl-C or a row that differs, 2 for a bad study.

    1 too where nodes fail in a replay.
    """
    replays = list(arguments[:1]) == ["replay"]
    options = _replay_parser().parse_args(arguments[1:]) if replays else _parsed(arguments)
    stop.from_now_on_wait(impatient=True)
    work = _replay if replays else _sweep
    try:
        return work(options, stop)
    except ValueError as error:
        print(error, file=sys.stderr)
        return 2
    except RuntimeError as error:
        print(error, file=sys.stderr)
        return 1
    except OSError as error:
        # A replay writes nothing.
        read = f"{error.filename or options.output}: {error.strerror}"
        print(read if replays else named_or_as_it_is(error), file=sys.stderr)
        return 2


def _sweep(options: argparse.Namespace, stop: Stop) -> int:
    # They load numba: not for help.
    from rodless_lab.studies.files_read import files_read  # noqa: PLC0415
    from rodless_lab.studies.part import parquet_modules  # noqa: PLC0415
    from rodless_lab.studies.report import report_files, write_report  # noqa: PLC0415
    from rodless_lab.studies.study import read_study  # noqa: PLC0415
    from rodless_lab.studies.sweep import run_sweep  # noqa: PLC0415

    # To read a study may compile for a while.
    parquet_modules()
    study = read_study(options.study)
    folder = options.output or FOLDER / study.name
    check_none_is_read(report_files(folder), files_read("studies", options.study, "the study"))
    progress = Progress()
    if options.scheduler and options.workers:
        print(
            f"--workers {options.workers}: left out, the workers of --scheduler run the rows",
            file=sys.stderr,
        )

    def show(known: int, total: int) -> None:
        progress.show(f"{known} of {total} rows", last=known == total)

    check_files_writable(report_files(folder))
    complete = run_sweep(
        study, folder, options.workers, options.scheduler, show, lambda: stop.requested
    )
    if not complete:
        print(f"interrupted; the same command goes on in {folder}", file=sys.stderr)
        return 1
    print(write_report(folder, study))
    print(f"rows: {folder / 'rows'}, summary: {folder / 'summary.md'}, pictures beside it")
    return 0


def _replay(options: argparse.Namespace, stop: Stop) -> int:  # noqa: ARG001
    from rodless_lab.studies.replay import replay_row  # noqa: PLC0415

    folder = options.output or _latest()
    differences = replay_row(folder, options.row, ros=options.ros)
    where = "over DDS in lock-step" if options.ros else "in process"
    if differences:
        print(f"row {options.row} of {folder}, {where}: differs", file=sys.stderr)
        print("\n".join(differences), file=sys.stderr)
        return 1
    print(f"row {options.row} of {folder}, {where}: equal bit for bit")
    return 0


def _latest() -> Path:
    """Return the folder of the sweep that was begun last; raises ValueError where there is none."""
    found = sorted(FOLDER.glob("*/study.json"), key=lambda file: file.stat().st_mtime)
    if not found:
        raise ValueError(f"{FOLDER}: no sweep there; give its folder as --output")
    return found[-1].parent


def _parsed(arguments: Sequence[str]) -> argparse.Namespace:
    parser = Parser(
        prog="rodless sweep",
        description="Run each row of a study, and keep its figures. The same command goes on with "
        "a sweep that was interrupted. See docs/sweeps.md.",
        epilog="`rodless sweep replay ROW` runs one row again and compares it. Exit code: 0 all "
        "rows known; 1 interrupted, or a row that differs; 2 a study or file that cannot be used.",
    )
    parser.add_argument("study", metavar="STUDY", help="a YAML file, or one that ships: friction")
    _add_output(parser)
    parser.add_argument("--workers", type=whole, help="threads (default: one for each core)")
    parser.add_argument(
        "--scheduler", metavar="ADDRESS", help="of a Dask cluster that runs the rows instead"
    )
    return parser.parse_args(arguments)


def _replay_parser() -> Parser:
    parser = Parser(
        prog="rodless sweep replay",
        description="Run one row of a sweep again and compare all of its numbers bit for bit.",
    )
    parser.add_argument("row", type=whole, metavar="ROW")
    _add_output(parser)
    parser.add_argument(
        "--ros", action="store_true", help="by the nodes, over DDS in lock-step, too"
    )
    return parser


def _add_output(parser: Parser) -> None:
    parser.add_argument(
        "-o", "--output", type=named_path, help=f"folder of the sweep (default: in {FOLDER})"
    )
