# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless compare`: overlay two runs and report their differences as the paper does."""

import argparse
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from rodless_base.command_line import Parser, named_path
from rodless_base.parameter_file import preset_names
from rodless_base.start import Stop
from rodless_lab.cli.exit_code import exit_code
from rodless_lab.cli.notes import print_notes
from rodless_lab.cli.overwriting import check_none_is_read
from rodless_lab.reports.differences import (
    IN_PLACE,
    Pair,
    check_differences_writable,
    difference_files,
    differences_table,
    write_differences,
)
from rodless_lab.runs.comparison import aligned, common_time, differences
from rodless_lab.runs.from_bag import naming, read_run_and_setpoint
from rodless_lab.runs.measured_run import MeasuredRun, RunError, Setpoint
from rodless_lab.runs.resimulate import follow, resimulate
from rodless_sim import RigParameters


def main(arguments: Sequence[str], stop: Stop) -> int:  # noqa: ARG001
    """Return 0 once picture and numbers are written, 2 for a run that cannot be used."""
    options = _parser().parse_args(arguments)

    def look(folder: Path) -> None:
        check_none_is_read(difference_files(folder / "compare"))
        check_differences_writable(folder / "compare")

    return exit_code(lambda: _compare(options), options.output, look)


def _compare(options: argparse.Namespace) -> None:
    if str(options.bag) in preset_names() and not options.bag.exists():
        raise RunError(f"{options.bag}: a preset can only stand first; BAG must be a bag")
    second, setpoint = read_run_and_setpoint(options.bag, options.namespace)
    _report(options, _pair(options, second, setpoint))


def _parser() -> Parser:
    parser = Parser(
        prog="rodless compare",
        description="Overlay two runs; differences are second minus first.",
        epilog=f"Presets: {', '.join(preset_names())}. A preset is simulated with what drove BAG.",
    )
    parser.add_argument("first", metavar="BAG_OR_PRESET")
    parser.add_argument("bag", type=named_path, metavar="BAG")
    parser.add_argument(
        "-o", "--output", type=named_path, default=Path("results/compare"), help="folder"
    )
    parser.add_argument("--namespace", default="", help="of the rig's topics, such as /rig1")
    parser.add_argument(
        "--drive",
        choices=("voltage", "setpoint"),
        help="what of BAG drives the preset: its recorded voltage, or its set-points (default: "
        "voltage)",
    )
    return parser


def _pair(options: argparse.Namespace, second: MeasuredRun, setpoint: Setpoint | None) -> Pair:
    """Return both runs on one time: the preset simulated like ``second``, or the first bag."""
    if options.first not in preset_names() or Path(options.first).exists():
        if options.drive is not None:
            raise RunError("--drive: refused for two bags, none is simulated; leave it out")
        recorded = read_run_and_setpoint(options.first, options.namespace)
        return aligned(recorded, (second, setpoint))
    with naming(options.bag):
        return _simulated(options, second, setpoint), second


def _simulated(
    options: argparse.Namespace, second: MeasuredRun, setpoint: Setpoint | None
) -> MeasuredRun:
    if options.drive in (None, "voltage"):
        return resimulate(RigParameters.preset(options.first), second)
    if setpoint is None:
        raise RunError("no set-points that are numbers were recorded; compare with --drive voltage")
    if setpoint.doubt:
        raise RunError(f"{setpoint.doubt}, or compare with --drive voltage")
    return follow(options.first, second, setpoint)


def _report(options: argparse.Namespace, runs: Pair) -> None:
    names = (Path(options.first).resolve().name, options.bag.resolve().name)
    time = common_time(runs[0].time, runs[1].time)
    found = differences(*runs, time)
    numbers = {
        "first": names[0],
        "second": names[1],
        "duration": float(time[-1] - time[0]),
        "differences": {name: asdict(value) for name, value in found.items()},
    }
    replaced = write_differences(options.output / "compare", names, runs, time, numbers)
    print(differences_table(names, found))
    print_notes(*runs)
    print(f"compare.json and compare.png are in {options.output}{IN_PLACE if replaced else ''}")
