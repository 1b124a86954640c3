"""What the verbs that talk to a running rig share: options, and errors in one line."""

import argparse
import math
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING

from rodless_base.start import Stop

if TYPE_CHECKING:
    from rodless_lab.session.running_rig import RunningRig

NOT_POSSIBLE = 2


def add_namespace(parser: argparse.ArgumentParser) -> None:
    """Add the option that says which rig."""
    parser.add_argument("--namespace", default="", help="of the rig, such as /rig1")


def seconds(text: str) -> float:
    """Return a positive number of seconds; raises ArgumentTypeError for another text."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} is not a positive number of seconds")
    return value


def with_rig(namespace: str, stop: Stop, work: "Callable[[RunningRig], int]") -> int:
    """Return what ``work`` returns on a running rig.

    Returns 2 with a line on standard error where it cannot be done, 1 where the user ends it.
    """
    # Here, so that help is quick and works without ROS.
    from rodless_lab.session.errors import HarnessError, InterruptedRunError  # noqa: PLC0415
    from rodless_lab.session.running_rig import RunningRig  # noqa: PLC0415

    stop.from_now_on_wait()
    try:
        with RunningRig(namespace, stop) as rig:
            return work(rig)
    except HarnessError as error:
        print(error, file=sys.stderr)
        return NOT_POSSIBLE
    except InterruptedRunError:
        print("\ninterrupted; the rig keeps running", file=sys.stderr)
        return 1
