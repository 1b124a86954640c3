# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless identify`: from a bag of the rig's topics to a parameter file the plant loads."""

import argparse
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from rodless_base.atomic_write import (
    cannot_be_written,
    check_file_writable,
    check_files_writable,
    write_together,
)
from rodless_base.command_line import Parser, named_path
from rodless_base.parameter_file import preset_names
from rodless_base.start import Stop
from rodless_lab.cli.notes import print_notes
from rodless_lab.cli.overwriting import check_none_is_read
from rodless_lab.figures.files import png
from rodless_lab.identification.parameter_writer import findings_table, parameter_text, title
from rodless_lab.identification.plausible import check_run, frozen_sensors
from rodless_lab.identification.pressures.fit import MOST_BETWEEN_SAMPLES, check_change
from rodless_lab.identification.subjects import (
    SUBJECTS,
    UNVALIDATED,
    Identified,
    assumed_parameters,
)
from rodless_lab.identification.verdict import Verdict
from rodless_lab.runs.from_bag import read_run
from rodless_lab.runs.measured_run import MeasuredRun, RunError, UninformativeRunError
from rodless_lab.runs.same_run import mostly_known
from rodless_sim import ParameterError, RigParameters

MISFIT = 3

DEFAULT_BASE = "paper"

# How many times the first bag's a sample period of the second is worth a word.
COARSER = 1.1


def main(arguments: Sequence[str], stop: Stop) -> int:  # noqa: ARG001
    """Return 0 if parameters were identified by a model that fits.

    1 if none was, 2 for a bag that cannot be used, 3 if the model does not fit the run or, with
    ``--validate``, does not predict the second.
    """
    options = _parser().parse_args(arguments)
    try:
        check_file_writable(options.output)  # before it is asked for its name: / has none
        files = (options.output, _picture(options.output))
        check_files_writable(files)
        check_none_is_read(files, {Path(options.base): "--base"})
        return _identify(options)
    except ParameterError as error:  # of the base or an option: no bag is at fault
        print(error, file=sys.stderr)
        return 2
    except RunError as error:
        text = str(error)
        named = any(str(bag) in text for bag in (options.bag, options.validate) if bag)
        print(text if named else f"{options.bag}: {text}", file=sys.stderr)
        return 1 if isinstance(error, UninformativeRunError) else 2
    except OSError as error:
        print(cannot_be_written(error.filename or options.output, error), file=sys.stderr)
        return 2


def _picture(output: Path) -> Path:
    """Return where the residuals are drawn."""
    return output.with_suffix(".png")


def _identify(options: argparse.Namespace) -> int:
    parameters = assumed_parameters(options.base, options.sensors, options.namespace)
    run = read_run(options.bag, options.namespace)
    second = _second_run(options, run, parameters)
    found = SUBJECTS[options.subject](run, parameters)
    informed = any(finding.value is not None for finding in found.findings)
    print_notes(run) if second is None else print_notes(run, second)
    for bag, one in ((options.bag, run), (options.validate, second)):
        for line in () if one is None else frozen_sensors(one):
            print(f"{bag}: {line}", file=sys.stderr)
    print(findings_table(found.findings))
    _say(options, found.verdict, informed=informed)
    _write(options, found, run, informed=informed)
    predicts = second is None or _predicts(options, found, run, second)
    if not (predicts and found.verdict.fits):
        return MISFIT
    return 0 if informed else 1


def _say(options: argparse.Namespace, verdict: Verdict, *, informed: bool) -> None:
    """Print what the table is worth, before anything can fail."""
    if not informed:
        print(f"{options.bag}: informs none of these; no parameters are written", file=sys.stderr)
    if verdict.fits:
        print(f"{verdict}")
    else:
        print(f"{verdict}; the intervals above do not hold", file=sys.stderr)


def _write(
    options: argparse.Namespace, found: Identified, run: MeasuredRun, *, informed: bool
) -> None:
    """Write the parameters, if any are ``informed``, and draw the residuals; say where they are."""
    if not informed and found.verdict.fits:
        return
    picture = _picture(options.output)
    results: dict[Path, str | bytes] = {picture: png(found.draw)}
    if informed:
        bag, base = options.bag.resolve().name, Path(options.base).name
        heading = title(options.subject, bag, run, options.sensors, base)
        heading.append(f"Verdict: {found.verdict}.")
        results[options.output] = parameter_text(heading, found.findings)
    write_together(results)
    if informed:
        print(
            f"written to {options.output}; for `rodless rig --parameters`, or the plant's "
            f"--params-file{_rests_on(options.base)}"
        )
    print(f"{picture} shows the residuals")


def _rests_on(base: str) -> str:
    """Say what has to be loaded with the values, which are those of a rig like ``base``."""
    if base == DEFAULT_BASE:
        return ""
    if base in preset_names():
        return f", with the preset {base}"
    return f", together with what {base} sets: they hold for that rig alone"


def _second_run(
    options: argparse.Namespace, first: MeasuredRun, parameters: RigParameters
) -> MeasuredRun | None:
    """Read the run to predict, if there is to be one; RunError for one that tests nothing."""
    if options.validate is None:
        return None
    if options.subject in UNVALIDATED:
        raise ParameterError(
            f"--validate: refused for {options.subject}, {UNVALIDATED[options.subject]} "
            "and predicts no run; identify both bags and compare the intervals"
        )
    with _named(options.validate):
        second = read_run(options.validate, options.namespace)
        check_run(second, parameters, longest=MOST_BETWEEN_SAMPLES)
        check_change(second, parameters)
        if mostly_known(second, first):
            raise RunError(
                f"{options.validate}: refused, most of it is in {options.bag}, which is fitted; "
                "take another run"
            )
    return second


def _predicts(
    options: argparse.Namespace, found: Identified, first: MeasuredRun, second: MeasuredRun
) -> bool:
    """Print how each model predicts the second run; whether the one that was written does."""
    if found.validate is None:
        return True
    with _named(options.validate):
        validation = found.validate(second)
    print(f"fitted to {options.bag}, left of {options.validate}:")
    for prediction in (validation.plain, *validation.others):
        print(f"  {prediction}")
    predicted = validation.plain.predicts
    print(f"{validation}", file=sys.stdout if predicted else sys.stderr)
    if not predicted and second.period > COARSER * first.period:
        print(
            f"{options.validate}: a sample every {second.period:.3g} s, of {options.bag} every "
            f"{first.period:.3g} s: how the rig moves between them is not seen",
            file=sys.stderr,
        )
    return predicted


@contextmanager
def _named(bag: Path) -> Iterator[None]:
    """Name the bag in what is said of its run: a second one that informs nothing is unusable."""
    try:
        yield
    except RunError as error:
        text = str(error)
        raise RunError(text if str(bag) in text else f"{bag}: {text}") from error


def _parser() -> Parser:
    parser = Parser(
        prog="rodless identify",
        description="Identify parameters of a rig from a recorded run.",
        epilog="Topics read: joint_states, chamber_a/pressure, chamber_b/pressure, "
        "supply/pressure, valve/state (or valve/voltage). Pressures are absolute. Exit code: 0 "
        "found; 1 the run tells none of the parameters; 2 it cannot be used; 3 the model does not "
        "fit it, or does not predict the bag of --validate. FILE.png shows the residuals.",
    )
    parser.add_argument("subject", choices=sorted(SUBJECTS))
    parser.add_argument("bag", type=named_path, metavar="BAG", help="folder of a rosbag2 bag")
    parser.add_argument("-o", "--output", type=_parameter_file, required=True, metavar="FILE.yaml")
    parser.add_argument(
        "--validate",
        type=named_path,
        metavar="BAG",
        help="a second bag of the same rig: which model, fitted to the first, predicts it",
    )
    parser.add_argument("--namespace", default="", help="of the rig, such as /rig1")
    parser.add_argument(
        "--base",
        default=DEFAULT_BASE,
        metavar="PRESET|FILE",
        help="parameters taken as known: a preset or a parameter file (default: paper)",
    )
    parser.add_argument(
        "--sensors",
        choices=("data-sheet", "base", "ideal"),
        default="data-sheet",
        help="accuracy of the sensors: of the paper's (default), as in --base, or perfect",
    )
    return parser


def _parameter_file(text: str) -> Path:
    file = named_path(text)
    if file.suffix == ".png":
        raise argparse.ArgumentTypeError(f"the residuals are drawn in {text!r}; end it in .yaml")
    return file
