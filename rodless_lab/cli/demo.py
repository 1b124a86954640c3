# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless demo`: both nodes over DDS move the carriage 0 -> 58 mm; a bag, a table, a picture."""

import sys
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from rodless_base.atomic_write import cannot_be_written
from rodless_base.command_line import Parser, named_path
from rodless_base.constants import STANDARD_ATMOSPHERE
from rodless_base.parameter_file import preset_names
from rodless_base.start import Stop
from rodless_lab.bags.metadata import BagError
from rodless_lab.reports.differences import IN_PLACE
from rodless_lab.results_folder import results_folder
from rodless_lab.runs.step_metrics import SETTLING_BAND, metric_lines
from rodless_lab.session.errors import HarnessError, InterruptedRunError

if TYPE_CHECKING:
    from rodless_lab.demo import Outcome


def main(arguments: Sequence[str], stop: Stop) -> int:
    """Return 0 if the carriage ends within 0.2 mm of the target.

    Returns 1 where the run fails or is interrupted, 2 for a folder that cannot be written to.
    """
    parser = Parser(prog="rodless demo", description=__doc__)
    parser.add_argument("--preset", default="paper", choices=preset_names())
    parser.add_argument(
        "-o", "--output", type=named_path, default=Path("results/demo"), help="folder"
    )
    options = parser.parse_args(arguments)
    # Here, so that help works without ROS.
    from rodless_lab.demo import earlier_results  # noqa: PLC0415

    stop.from_now_on_wait()
    with ExitStack() as stack:
        try:
            stack.enter_context(results_folder(options.output))
            replaced = stack.enter_context(earlier_results(options.output))
        except HarnessError as error:
            print(error, file=sys.stderr)
            return 2
        except OSError as error:
            print(cannot_be_written(error.filename or options.output, error), file=sys.stderr)
            return 2
        return run(options.preset, options.output, replaced, stop)


def run(preset: str, folder: Path, replaced: bool, stop: Stop) -> int:
    """Move, measure and print; return the exit code. ``replaced``: an earlier demo was there."""
    from rodless_lab.demo import BAG, move, write_results  # noqa: PLC0415

    bag = folder / BAG
    print("starting plant and controller (the first start compiles them)", flush=True)
    try:
        move(preset, bag, stop, show_start, show_progress)
        outcome = write_results(preset, bag, folder)
    except InterruptedRunError:
        recorded = f"what was recorded is in {bag}" if bag.exists() else "nothing was recorded"
        print(f"\ninterrupted; {recorded}", file=sys.stderr)
        return 1
    except (RuntimeError, BagError) as error:
        print(f"\n{error}", file=sys.stderr)
        return 1
    except OSError as error:
        print(f"\n{cannot_be_written(error.filename or folder, error)}", file=sys.stderr)
        return 1
    print_table(preset, outcome)
    print(f"bag, metrics.json and step.png are in {folder}{IN_PLACE if replaced else ''}")
    if abs(outcome.metrics.final_error) > SETTLING_BAND:
        print("the final error exceeds 0.2 mm", file=sys.stderr)
        return 1
    return 0


def show_start(target: float) -> None:
    """Say that the move to ``target`` (m) begins."""
    print(f"moving to {target * 1e3:g} mm", flush=True)


def show_progress(share: float, position: float) -> None:
    """Show how far the run is: on a terminal a line that is written over, elsewhere nothing."""
    if sys.stdout.isatty():
        bar = "#" * round(30 * share)
        end = "\n" if share == 1.0 else ""
        print(f"\r[{bar:30}] carriage at {position * 1e3:7.3f} mm", end=end, flush=True)


def print_table(preset: str, outcome: "Outcome") -> None:
    """Print what was measured."""
    gauge = outcome.supply_pressure - STANDARD_ATMOSPHERE
    print(f"{'preset':28}{preset:>12}")
    print("\n".join(metric_lines(outcome.metrics)))
    print(f"{'supply pressure, gauge':28}{gauge * 1e-6:12.3f} MPa")
