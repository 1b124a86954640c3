# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless soak`: long runs of the nodes, with a report on memory, losses and balance."""

import argparse
import math
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from rodless_base.atomic_write import atomic_write, cannot_be_written
from rodless_base.command_line import Parser, named_path
from rodless_base.start import Stop
from rodless_lab.cli.exit_code import can_be_written
from rodless_lab.cli.number import number, whole
from rodless_lab.cli.overwriting import check_result_file

if TYPE_CHECKING:
    from rodless_lab.soak.ros.soak import Soak


# Of fewer steps what the first ones leave open is too large a share of the turnover.
FEWEST_STEPS = 10_000

# Within less, memory is not read a second time.
SHORTEST = 10.0  # s


class _InterruptedError(Exception):
    """The user has asked to stop."""


def main(arguments: Sequence[str], stop: Stop) -> int:
    """Run, print and write the report; return 1 where something is not as it should be."""
    options = _options(arguments)
    # They load numba and ROS: not for help.
    from rodless_lab.soak.report import complaints, summary  # noqa: PLC0415
    from rodless_lab.soak.ros.soak import soak_lockstep, soak_realtime  # noqa: PLC0415

    stop.from_now_on_wait()

    def check() -> None:
        if stop.requested:
            raise _InterruptedError

    runs: list[Callable[[Callable[[str], None], Callable[[], object]], Soak]] = []
    if options.seconds:
        runs.append(partial(soak_realtime, options.seconds))
    if options.steps:
        runs.append(partial(soak_lockstep, options.steps))
    if not can_be_written(options.output, check_result_file):
        return 2
    texts, wrong = [], []
    try:
        for run in runs:
            found = run(lambda line: print(line, file=sys.stderr, flush=True), check)
            texts.append(summary(found))
            wrong += complaints(found)
            print(texts[-1], flush=True)
            if not _written(options.output, "\n\n".join([*texts, *wrong]) + "\n"):
                return 2
    except _InterruptedError:
        print("interrupted", file=sys.stderr)
        return 1
    except (RuntimeError, OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 1
    print("\n".join(wrong), end="\n" if wrong else "", file=sys.stderr)
    return int(bool(wrong))


def _written(path: Path, text: str) -> bool:
    """Write the report; whether it could be, said on standard error where not."""
    try:
        atomic_write(path, text)
    except OSError as error:
        print(cannot_be_written(path, error), file=sys.stderr)
        return False
    return True


def _options(arguments: Sequence[str]) -> argparse.Namespace:
    parser = Parser(
        prog="rodless soak",
        description="Run plant and controller for long: in real time, then in lock-step, where "
        "each sample is compared with the run without nodes.",
        epilog="Exit code: 0 no sample lost, memory flat, balance closed; 1 anything else, 2 an "
        "output that cannot be written. Commands and positions that did not come in time are shown "
        "alone; see docs/reliability.md.",
    )
    parser.add_argument(
        "--seconds", type=_seconds, default=3600.0, help="real time (default: %(default)g); 0: none"
    )
    parser.add_argument(
        "--steps", type=_steps, default=10_000_000, help="lock-step (default: %(default)d); 0: none"
    )
    parser.add_argument(
        "-o",
        "--output",
        type=named_path,
        default=Path("results/soak/soak.md"),
        help="the report (default: %(default)s)",
    )
    options = parser.parse_args(arguments)
    if not (options.seconds or options.steps):
        parser.error("--seconds 0 and --steps 0: nothing to run")
    return options


def _steps(text: str) -> int:
    count = whole(text)
    if 0 < count < FEWEST_STEPS:
        raise argparse.ArgumentTypeError(
            f"{count} steps are too few to tell whether the balance closes: at least {FEWEST_STEPS}"
        )
    return count


def _seconds(text: str) -> float:
    value = number(text)
    if not 0.0 <= value < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} is no number of seconds")
    if 0.0 < value < SHORTEST:
        raise argparse.ArgumentTypeError(
            f"{text} s are too short to tell anything of memory: at least {SHORTEST:g}"
        )
    return value
