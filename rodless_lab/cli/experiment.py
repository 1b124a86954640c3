# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless experiment`: repeat an experiment of the paper, or all, beside what they report."""

import argparse
import sys
import time
from collections.abc import Iterable, Sequence
from pathlib import Path

from rodless_base.atomic_write import cannot_be_written, check_files_writable
from rodless_base.command_line import Parser, named_path
from rodless_base.parameter_file import preset_names
from rodless_base.start import Stop
from rodless_lab.cli.number import millimetres, whole
from rodless_lab.experiments import sine
from rodless_lab.experiments.catalogue import EXPERIMENTS
from rodless_lab.experiments.experiment import Options
from rodless_lab.experiments.runner import IN_PROCESS, Runner
from rodless_lab.reports.report import Performed, report_files, write_report
from rodless_lab.reports.table import cells, verdict
from rodless_lab.results_folder import results_folder
from rodless_sim import RigParameters

# Options of the user by the field of Options that they set.
FLAGS = {
    "presets": "--preset",
    "amplitude": "--amplitude",
    "centre": "--centre",
    "position": "--position",
    "seed": "--seed",
}

# Those in mm, and of what they are.
LENGTHS = {"amplitude": "sine", "centre": "sine", "position": "held piston"}


def main(arguments: Sequence[str], stop: Stop) -> int:
    """Return 0 if every judged number keeps its limits, 1 if one leaves them, 2 for bad options.

    1 too where the nodes do not finish a run.
    """
    options = parsed(arguments)
    names = list(EXPERIMENTS) if options.name == "all" else [options.name]
    folder = options.output or default_folder(options.name)
    try:
        runner = over_ros(options.name) if options.ros else IN_PROCESS
        checked = chosen(options, runner)
        with results_folder(folder) as stop.undo:
            check_files_writable(report_files(folder))
            performed = perform(names, checked)
            if len(names) == 1:
                print_rows(performed[0])
            report, summary = write_report(folder, performed)
    except ValueError as error:
        print(error, file=sys.stderr)
        return 2
    except OSError as error:
        print(cannot_be_written(error.filename or folder, error), file=sys.stderr)
        return 2
    except RuntimeError as error:
        print(error, file=sys.stderr)
        return 1
    print(f"report: {report}, summary: {summary}, pictures as PNG, PDF and CSV beside them")
    holds = all(row.holds for one in performed for row in one.result.comparisons)
    return 0 if holds else 1


def over_ros(name: str) -> Runner:
    """Return the runner of the nodes, which shows a dot for each of its runs.

    Raises ValueError for the name of an experiment that has nothing to drive.
    """
    if name != "all" and not EXPERIMENTS[name].moves:
        able = ", ".join(other for other, one in EXPERIMENTS.items() if one.moves)
        raise ValueError(f"--ros: {name} has no moving rig to drive; these have: {able}")
    from rodless_lab.experiments.ros_runner import nodes_runner  # noqa: PLC0415  needs ROS

    return nodes_runner(lambda: print(".", end="", flush=True))


def chosen(options: argparse.Namespace, runner: Runner) -> Options:
    """Return the options in SI; raises ValueError for those without effect or out of range."""
    given = {name: value for name in FLAGS if (value := getattr(options, name)) is not None}
    given |= {name: given[name] * 1e-3 for name in LENGTHS if name in given}
    if options.name != "all":
        _refuse_what_has_no_effect(options.name, given)
    presets = tuple(given.pop("presets", Options.presets))
    asked = Options(presets, **given, runner=runner)
    stroke = RigParameters().number("cylinder.stroke")
    if not 0.0 <= asked.position <= stroke:
        raise ValueError(
            f"--position {asked.position * 1e3:g}: must be from 0 to {stroke * 1e3:g} mm, "
            "the stroke"
        )
    sine.check_within_stroke(asked.amplitude, asked.centre)
    return asked


def _refuse_what_has_no_effect(name: str, given: Iterable[str]) -> None:
    """Raise ValueError for an option that the experiment does not take."""
    for one in given:
        if one not in EXPERIMENTS[name].takes:
            able = [other for other, experiment in EXPERIMENTS.items() if one in experiment.takes]
            raise ValueError(f"{FLAGS[one]}: {name} does not take it; these do: {', '.join(able)}")


def perform(names: Sequence[str], options: Options) -> list[Performed]:
    """Perform experiments one by one and say how far it is."""
    performed = []
    for count, name in enumerate(names, 1):
        experiment = EXPERIMENTS[name]
        still = options.runner is not IN_PROCESS and not experiment.moves
        where = " (no moving rig: in process)" if still else ""
        print(f"[{count}/{len(names)}] {name}{where} ... ", end="", flush=True)
        start = time.monotonic()
        try:
            performed.append(Performed(experiment, experiment.run(options)))
        except BaseException:
            print()
            raise
        rows = performed[-1].result.comparisons
        print(f"{time.monotonic() - start:.1f} s, {verdict(rows)}", flush=True)
    return performed


def parsed(arguments: Sequence[str]) -> argparse.Namespace:
    """Read the command line; lengths are in mm there."""
    parser = Parser(
        prog="rodless experiment",
        description=__doc__,
        epilog="\n".join(
            f"  {name:17} {one.title} ({one.source})" for name, one in EXPERIMENTS.items()
        ),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("name", choices=[*EXPERIMENTS, "all"], metavar="name", help="or all")
    default = Options()
    parser.add_argument(
        "--preset",
        dest="presets",
        action="append",
        choices=preset_names(),
        help="whose step, sine or frequency response (default: both)",
    )
    for name, of in LENGTHS.items():
        shown = getattr(default, name) * 1e3
        parser.add_argument(f"--{name}", type=millimetres, help=f"of the {of}, mm ({shown:g})")
    parser.add_argument(
        "--ros",
        action="store_true",
        help="let the nodes do what moves, over topics in lock-step (default: in process)",
    )
    parser.add_argument("--seed", type=whole, help=f"of the sensors' noise ({default.seed})")
    parser.add_argument(
        "-o",
        "--output",
        type=named_path,
        help="folder (results/experiments, or results/experiments/NAME)",
    )
    return parser.parse_args(arguments)


def default_folder(name: str) -> Path:
    """Return where a report goes unless told otherwise."""
    return Path("results/experiments") if name == "all" else Path("results/experiments") / name


def print_rows(performed: Performed) -> None:
    """Print what was obtained beside the paper's, one line each."""
    for row in performed.result.comparisons:
        quantity, obtained, paper, limits, holds, _ = cells(row)
        print(f"  {quantity:62} {obtained:>16}   {limits:>20} {holds:4} paper: {paper}")
    for remark in performed.result.remarks:
        print(f"  - {remark}")
