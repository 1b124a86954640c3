# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless laws`: the control laws side by side, yours among them."""

import sys
from collections.abc import Sequence
from pathlib import Path

from rodless_base.atomic_write import cannot_be_written, check_files_writable, write_together
from rodless_base.command_line import Parser, named_path
from rodless_base.one_line import OneLineError
from rodless_base.start import Stop
from rodless_lab.cli.number import count_up_to, positive_whole
from rodless_lab.cli.overwriting import check_none_is_read
from rodless_lab.results_folder import results_folder

# All rigs are in memory from the beginning, of every run there are figures in the end: some
# hundred megabytes of rigs. They would run for days.
MOST_RIGS = 100_000


def main(arguments: Sequence[str], stop: Stop) -> int:
    """Write table, picture and figures of each run; return 1 after Ctrl-C, 2 for bad options."""
    parser = Parser(
        prog="rodless laws",
        description="Let the control laws do seeded tasks on the same random rigs, and compare.",
        epilog="LAW is a law of this package, or package.module:Class of your own; see "
        "docs/laws.md.",
    )
    parser.add_argument(
        "--law",
        action="append",
        metavar="LAW[=FILE]",
        help="with parameters of a file; repeat it (default: those of the package)",
    )
    parser.add_argument(
        "--rigs", type=count_up_to(MOST_RIGS), default=100, help="rigs (default: %(default)s)"
    )
    parser.add_argument("--seed", type=positive_whole, default=1, help="(default: %(default)s)")
    parser.add_argument(
        "-o",
        "--output",
        type=named_path,
        default=Path("results/laws"),
        help="folder (default: %(default)s)",
    )
    chosen = parser.parse_args(arguments)
    # They load numba and matplotlib: not for help.
    from rodless_lab.benchmark.laws import entries  # noqa: PLC0415
    from rodless_lab.benchmark.laws.contest import contest  # noqa: PLC0415
    from rodless_lab.benchmark.laws.picture import side_by_side  # noqa: PLC0415
    from rodless_lab.benchmark.laws.tables import markdown, rows  # noqa: PLC0415
    from rodless_lab.benchmark.laws.tasks import rigs, tasks  # noqa: PLC0415
    from rodless_lab.figures.files import figure_contents, files_of_figure  # noqa: PLC0415

    try:
        laws = entries.users(chosen.law) if chosen.law else entries.of_package()
        drawn = rigs(chosen.rigs, chosen.seed)
        text_file, table_file = chosen.output / "laws.md", chosen.output / "runs.csv"
        files = (text_file, table_file, *files_of_figure(chosen.output, "laws"))
        read = entries.files_of_users(chosen.law or ())
        check_none_is_read(files, dict.fromkeys(read, "parameters of --law"))
        with results_folder(chosen.output) as stop.undo:
            check_files_writable(files)
            scores = contest(
                laws,
                tasks(chosen.seed),
                drawn,
                lambda name: print(name, file=sys.stderr, flush=True),
                lambda: stop.requested,
            )
            stop.from_now_on_wait()
            text = markdown(scores)
            print(text)
            contents = figure_contents(chosen.output, "laws", lambda: side_by_side(scores))
            write_together({**contents, table_file: rows(scores), text_file: text})
    except OneLineError as error:
        print(error, file=sys.stderr)
        return 2
    except OSError as error:
        print(cannot_be_written(error.filename or chosen.output, error), file=sys.stderr)
        return 2
    return 0
