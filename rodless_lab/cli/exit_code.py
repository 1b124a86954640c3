"""How the commands end that read bags and write into a folder."""

import sys
from collections.abc import Callable
from pathlib import Path

from rodless_lab.runs.measured_run import RunError
from rodless_sim import ParameterError


def exit_code(work: Callable[[], None], folder: Path) -> int:
    """Do ``work``; return 0, or 2 after a line about a run or ``folder`` that cannot be used."""
    try:
        work()
    except (RunError, ParameterError) as error:
        print(error, file=sys.stderr)
        return 2
    except OSError as error:
        print(f"{folder}: cannot be written: {error.strerror}", file=sys.stderr)
        return 2
    return 0
