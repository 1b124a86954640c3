# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless bench`: what the rig, other solvers and the nodes cost on this machine."""

import importlib.util
import json
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from rodless_base.atomic_write import (
    atomic_write,
    check_files_writable,
    named_or_as_it_is,
    write_together,
)
from rodless_base.command_line import Parser, named_path
from rodless_base.start import Stop
from rodless_lab.cli.exit_code import can_be_written
from rodless_lab.cli.overwriting import check_result_file
from rodless_lab.results_folder import results_folder

DESCRIPTION = (
    "Measure the rig beside other solvers, with errors, how many rigs run at once, and what the "
    "nodes cost."
)


class _InterruptedError(Exception):
    """The user has asked to stop."""


def main(arguments: Sequence[str], stop: Stop) -> int:
    """Print tables and write all numbers as JSON; return 1 after Ctrl-C.

    2 without psutil, and for an output that cannot be written. Beside the JSON stand the tables as
    Markdown and the work–precision picture.
    """
    parser = Parser(prog="rodless bench", description=DESCRIPTION)
    parser.add_argument(
        "-o",
        "--output",
        type=named_path,
        help="all numbers (default: results/bench/metrics.json, PART.json with --only); tables "
        "and picture go beside it",
    )
    parser.add_argument("--only", choices=tuple(PARTS), help="leave the others out")
    options = parser.parse_args(arguments)
    if options.only != "solvers" and importlib.util.find_spec("psutil") is None:
        print("rodless bench needs psutil: pip install 'rodless_sim[bench]'", file=sys.stderr)
        return 2
    stop.from_now_on_wait(impatient=True)

    def check() -> None:
        if stop.requested:
            raise _InterruptedError

    # The figures of one part do not replace those of a whole run.
    output: Path = options.output or Path("results/bench", f"{options.only or 'metrics'}.json")
    if not can_be_written(output, check_result_file):
        return 2
    figures: dict[str, float] = {}
    try:
        with results_folder(output.parent):
            for name, part in PARTS.items():
                if options.only in (None, name):
                    figures |= part(output.parent, check)
            atomic_write(output, json.dumps(figures, indent=2, ensure_ascii=False) + "\n")
    except _InterruptedError:
        print("interrupted", file=sys.stderr)
        return 1
    except OSError as error:
        print(named_or_as_it_is(error), file=sys.stderr)
        return 2
    except RuntimeError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


def _solvers(folder: Path, check: Callable[[], None]) -> dict[str, float]:
    # They load numba and matplotlib: not for help.
    from rodless_lab.benchmark.picture import work_precision  # noqa: PLC0415
    from rodless_lab.benchmark.side_by_side import bench_side_by_side  # noqa: PLC0415
    from rodless_lab.benchmark.tables import markdown  # noqa: PLC0415
    from rodless_lab.figures.files import figure_contents, files_of_figure  # noqa: PLC0415

    page = folder / "side_by_side.md"
    check_files_writable((page, *files_of_figure(folder, "work_precision")))
    found = bench_side_by_side(check)
    tables = markdown(found)
    print(tables)
    contents = figure_contents(folder, "work_precision", lambda: work_precision(found))
    write_together({**contents, page: tables + "\n"})
    return found.figures()


def _ensembles(_folder: Path, check: Callable[[], None]) -> dict[str, float]:
    from rodless_lab.benchmark.ensembles import bench_ensembles  # noqa: PLC0415

    return _shown(bench_ensembles(check))


def _nodes(_folder: Path, check: Callable[[], None]) -> dict[str, float]:
    from rodless_lab.benchmark.ros.bare import bench_bare  # noqa: PLC0415
    from rodless_lab.benchmark.ros.nodes import bench_lockstep, bench_realtime  # noqa: PLC0415

    figures: dict[str, float] = {}
    for rate in (100.0, 500.0, 1000.0):
        figures |= bench_realtime(rate, check)
    figures |= bench_bare(1000.0, check)
    return _shown(figures | bench_lockstep(check) | bench_bare(0.0, check))


def _shown(figures: dict[str, float]) -> dict[str, float]:
    """Print figures, and return them."""
    for name, value in figures.items():
        print(f"{name:66} {value:10.4g}")
    return figures


PARTS = {"solvers": _solvers, "ensembles": _ensembles, "nodes": _nodes}
