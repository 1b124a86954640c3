# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless campaign`: how exactly random rigs follow their equations."""

import argparse
import sys
from collections.abc import Sequence
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

from rodless_base.atomic_write import atomic_write, check_files_writable, named_or_as_it_is
from rodless_base.command_line import Parser, named_path
from rodless_base.start import Stop
from rodless_lab.cli.number import positive_whole


def main(arguments: Sequence[str], stop: Stop) -> int:
    """Run the rigs, print and write the tables; return 1 where it ended early, 2 for a bad file."""
    parser = Parser(
        prog="rodless campaign",
        description="Run random rigs at the default and at a small time.tolerance, and show by how "
        "much they differ.",
        epilog="Ctrl-C interrupts it; the same command goes on where it was. Exit code: 0 all rigs "
        "known; 1 Ctrl-C, or a process of its own was killed; 2 a file that cannot be read or "
        "written. See docs/accuracy.md.",
    )
    parser.add_argument(
        "--count", type=positive_whole, default=10_000, help="rigs (default: %(default)s)"
    )
    parser.add_argument(
        "-o",
        "--output",
        type=_csv,
        default=Path("results/accuracy/campaign.csv"),
        help="figures of each rig (default: %(default)s); the tables go beside it, as .md",
    )
    chosen = parser.parse_args(arguments)
    stop.from_now_on_wait(impatient=True)
    # They load numba: not for help.
    from rodless_lab.accuracy.campaign import campaign  # noqa: PLC0415
    from rodless_lab.accuracy.summary import summary  # noqa: PLC0415

    def progress(known: int) -> None:
        if known % 100 == 0 or known == chosen.count:
            print(f"{known} of {chosen.count} rigs", file=sys.stderr, flush=True)

    tables = chosen.output.with_suffix(".md")
    try:
        check_files_writable((chosen.output, tables))
        verdicts = campaign(chosen.output, chosen.count, progress, lambda: stop.requested)
        if verdicts:  # tables of an earlier campaign say more than those of none
            text = summary(verdicts)
            print(text)
            atomic_write(tables, text)
    except OSError as error:
        print(named_or_as_it_is(error), file=sys.stderr)
        return 2
    except ValueError as error:
        print(error, file=sys.stderr)
        return 2
    except BrokenProcessPool:
        # By somebody, or by the system, which was out of memory.
        print("one of its processes was killed; the same command goes on", file=sys.stderr)
        return 1
    if len(verdicts) < chosen.count:
        print("interrupted; the same command goes on", file=sys.stderr)
        return 1
    return 0


def _csv(text: str) -> Path:
    file = named_path(text)
    if file.suffix != ".csv":
        raise argparse.ArgumentTypeError(f"{text!r} does not end in .csv")
    return file
