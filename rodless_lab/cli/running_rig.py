# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What the verbs that talk to a running rig share: options, and errors in one line."""

import argparse
import math
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING

from rodless_base.command_line import Parser
from rodless_base.start import Stop
from rodless_lab.cli.number import number

if TYPE_CHECKING:
    from rodless_lab.session.running_rig import RunningRig

NOT_POSSIBLE = 2

# For each answer of a node, in wall-clock s.
ANSWER_TIMEOUT = 10.0


def add_namespace(parser: Parser) -> None:
    """Add the option that says which rig."""
    parser.add_argument("--namespace", default="", help="of the rig, such as /rig1")


def add_timeout(parser: Parser, meaning: str, default: float = 10.0) -> None:
    """Add the option for how long to wait, in wall-clock s; ``meaning``: for what."""
    parser.add_argument(
        "--timeout",
        type=_seconds,
        default=default,
        metavar="S",
        help=f"{meaning} (default: %(default)g s)",
    )


def _seconds(text: str) -> float:
    value = number(text)
    if not 0.0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} is not a positive number of seconds")
    return value


def value_text(value: object) -> str:
    """Return a parameter's value as `rodless set` takes it."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str | int | float):
        return str(value)
    return ",".join(map(str, value)) if hasattr(value, "__iter__") else str(value)


def say_compiling() -> None:
    """Say why a change takes a minute."""
    line = "the plant compiles its equations for this first, which takes about a minute; waiting"
    print(line, file=sys.stderr, flush=True)


def with_rig(
    namespace: str, stop: Stop, work: "Callable[[RunningRig], int]", timeout: float = ANSWER_TIMEOUT
) -> int:
    """Return what ``work`` returns on a running rig; each answer may take ``timeout`` s.

    Returns 2 with a line on standard error where it cannot be done, 1 where the user ends it.
    """
    # Here, so that help is quick and works without ROS.
    from rodless_lab.session.errors import (  # noqa: PLC0415
        HarnessError,
        InterruptedRunError,
        WaitTimeoutError,
    )
    from rodless_lab.session.running_rig import RunningRig  # noqa: PLC0415

    stop.from_now_on_wait()
    try:
        with RunningRig(namespace, stop, timeout) as rig:
            try:
                return work(rig)
            except WaitTimeoutError as error:
                print("; ".join([str(error), *rig.obstacles()]), file=sys.stderr)
                return NOT_POSSIBLE
    except HarnessError as error:
        print(error, file=sys.stderr)
        return NOT_POSSIBLE
    except InterruptedRunError:
        print("\ninterrupted; what was running keeps running", file=sys.stderr)
        return 1
