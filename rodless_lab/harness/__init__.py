"""Plant and controller under a test: start, drive, disturb and record them, and clean up."""

from rodless_lab.session.commands import Alteration, Law
from rodless_lab.session.errors import (
    HarnessError,
    NodeDiedError,
    RefusedError,
    WaitTimeoutError,
)
from rodless_lab.session.live_session import Mode
from rodless_lab.session.samples import LostSampleError, Sample, Samples
from rodless_lab.session.session import RigSession

PatienceError = WaitTimeoutError  # its old name

__all__ = [
    "Alteration",
    "HarnessError",
    "Law",
    "LostSampleError",
    "Mode",
    "NodeDiedError",
    "PatienceError",
    "RefusedError",
    "RigSession",
    "Sample",
    "Samples",
    "WaitTimeoutError",
]
