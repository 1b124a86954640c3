# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless replay`: a bag's voltages for the plant, and how far it departs from the recording."""

import argparse
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from rodless_base.command_line import Parser, named_path
from rodless_base.one_line import shown
from rodless_base.parameter_file import preset_names, read_parameter_file
from rodless_base.parameters import errors_of_file
from rodless_base.start import Stop
from rodless_lab.cli.exit_code import exit_code
from rodless_lab.cli.notes import print_notes
from rodless_lab.cli.overwriting import check_none_is_read
from rodless_lab.identification.friction.run import bias_note
from rodless_lab.identification.parameter_writer import identified_subject
from rodless_lab.reports.differences import (
    IN_PLACE,
    check_differences_writable,
    difference_files,
    differences_table,
    write_differences,
)
from rodless_lab.runs.commands import summary
from rodless_lab.runs.comparison import differences
from rodless_lab.runs.from_bag import Recording, naming, read_commands, read_recording
from rodless_lab.runs.measured_run import MeasuredRun, RunError
from rodless_lab.runs.resimulate import replay
from rodless_sim import RigParameters


def main(arguments: Sequence[str], stop: Stop) -> int:  # noqa: ARG001
    """Return 0 once picture and numbers are written, 2 for a bag that cannot be replayed."""
    options = _parser().parse_args(arguments)

    def look(folder: Path) -> None:
        read = {} if options.parameters is None else {options.parameters: "--parameters"}
        check_none_is_read(difference_files(folder / "replay"), read)
        check_differences_writable(folder / "replay")

    return exit_code(lambda: _replay(options), options.output, look)


def _replay(options: argparse.Namespace) -> None:
    parameters = _parameters(options)
    recording = read_recording(options.bag, options.namespace)
    with naming(options.bag):
        replayed = replay(parameters, recording.run)
    _report(options, recording, replayed)


def _parser() -> Parser:
    parser = Parser(
        prog="rodless replay",
        description="Feed a bag's voltages and supply pressure to the plant, from the recorded "
        "start on, and report how far it departs from the recording.",
    )
    parser.add_argument("bag", type=named_path, metavar="BAG")
    parser.add_argument("--preset", default="paper", choices=preset_names())
    parser.add_argument(
        "--parameters", type=named_path, metavar="FILE", help="on top of the preset"
    )
    parser.add_argument(
        "-o", "--output", type=named_path, default=Path("results/replay"), help="folder"
    )
    parser.add_argument("--namespace", default="", help="of the rig, such as /rig1")
    return parser


def _parameters(options: argparse.Namespace) -> RigParameters:
    preset, file = RigParameters.preset(options.preset), options.parameters
    if file is None:
        return preset
    with errors_of_file(file):
        found = preset.with_values(
            read_parameter_file(file, RigParameters.NODE, RigParameters.foreign, options.namespace)
        )
    if scenario := found.text("time.scenario"):
        raise RunError(
            f"{file}: time.scenario: {shown(scenario)} refused, a replay does what the bag says; "
            "leave it out"
        )
    return found


def _report(options: argparse.Namespace, recording: Recording, replayed: MeasuredRun) -> None:
    recorded = recording.run
    names = (options.bag.resolve().name, "replay")
    runs, time = (recorded, replayed), recorded.time
    found = differences(*runs, time)
    numbers = {name: asdict(value) for name, value in found.items()}
    replaced = write_differences(options.output / "replay", names, runs, time, numbers)
    print(differences_table(names, found))
    print_notes(*runs)
    _print_commands(options.bag, options.namespace, recording)
    if options.parameters is not None and identified_subject(options.parameters) == "friction":
        print(f"{options.parameters.name} was identified: {bias_note()}")
    print(f"replay.json and replay.png are in {options.output}{IN_PLACE if replaced else ''}")


def _print_commands(bag: Path, namespace: str, recording: Recording) -> None:
    """Print how fast the commands came; a bag repeats by the valve's state without them, too."""
    run, begin = recording.run, recording.begin
    try:
        commands = read_commands(bag, namespace)
        used = commands.during(begin, begin + float(run.time[-1]))
        print(summary(used, run.period, recorded=len(commands.time)))
    except RunError as error:
        print(error, file=sys.stderr)
