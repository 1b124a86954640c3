# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless animate`: a run as a moving picture (GIF), the rig above its curves."""

import argparse
import math
from collections.abc import Sequence
from pathlib import Path

from rodless_base.command_line import Parser, named_path
from rodless_base.parameter_file import preset_names
from rodless_base.start import Stop
from rodless_lab.cli.exit_code import exit_code
from rodless_lab.cli.notes import print_notes
from rodless_lab.cli.number import real
from rodless_lab.cli.overwriting import check_result_file
from rodless_lab.figures.animation import Film, write_animation
from rodless_lab.reports.preset_step import preset_step
from rodless_lab.runs.from_bag import read_run_and_setpoint
from rodless_lab.runs.measured_run import MeasuredRun, RunError, Setpoint
from rodless_sim import RigParameters

# Longer ones would be files that nobody opens.
LONGEST = 60.0  # s of film


def main(arguments: Sequence[str], stop: Stop) -> int:  # noqa: ARG001
    """Return 0 once the picture is written, 2 for a run or a file that cannot be used."""
    options = _parser().parse_args(arguments)
    return exit_code(lambda: _animate(options), options.output, check_result_file)


def _parser() -> Parser:
    parser = Parser(
        prog="rodless animate",
        description="Draw a run as a moving picture (GIF): the rig above its curves.",
        epilog=f"Presets: {', '.join(preset_names())}. Of a preset its step to 58 mm is drawn.",
    )
    parser.add_argument("run", metavar="BAG_OR_PRESET")
    parser.add_argument("-o", "--output", type=named_path, required=True, metavar="FILE.gif")
    parser.add_argument("--namespace", default="", help="of the rig's topics, such as /rig1")
    parser.add_argument("--start", type=real, default=0.0, help="s into the run (default: 0)")
    parser.add_argument("--end", type=real, help="s into the run (default: its end)")
    parser.add_argument(
        "--speed", type=real, default=1.0, help="plant seconds in a second (default: 1)"
    )
    return parser


def _animate(options: argparse.Namespace) -> None:
    if options.output.suffix != ".gif":
        raise RunError(f"{options.output}: only GIF is written; end the name in .gif")
    run, setpoint = _run(options)
    film = _film(options, run)
    # A bag says nothing of the cylinder: it is drawn as long as ours, or as far as the run goes.
    stroke = max(RigParameters().number("cylinder.stroke"), float(run.position.max()))
    print_notes(run)
    frames = write_animation(options.output, run, setpoint, stroke, film)
    print(f"{options.output}: {frames} frames, {options.output.stat().st_size / 1e3:.0f} kB")


def _run(options: argparse.Namespace) -> tuple[MeasuredRun, Setpoint | None]:
    if options.run in preset_names() and not Path(options.run).exists():
        if options.namespace:
            raise RunError(f"--namespace {options.namespace}: refused, a preset has no topics")
        return preset_step(options.run)
    run, setpoint = read_run_and_setpoint(options.run, options.namespace)
    return run, None if setpoint is None or setpoint.doubt else setpoint


def _film(options: argparse.Namespace, run: MeasuredRun) -> Film:
    """Return what is asked for; raise RunError for what the run does not have."""
    last = float(run.time[-1])
    end = last if options.end is None else options.end
    if not 0.0 <= options.start < end <= last:
        raise RunError(
            f"{options.run}: {options.start:g} to {end:g} s refused, the run has 0 to {last:g} s"
        )
    if not 0.0 < options.speed < math.inf or (end - options.start) / options.speed > LONGEST:
        raise RunError(
            f"--speed {options.speed:g} refused, {end - options.start:g} s must take at most "
            f"{LONGEST:g} s; give a higher --speed, or --start and --end"
        )
    return Film(options.start, end, options.speed, Path(options.run).resolve().name)
