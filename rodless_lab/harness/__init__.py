"""Plant and controller under a test: start, drive, disturb and record them, and clean up."""

from rodless_lab.session.commands import Alteration, Law
from rodless_lab.session.errors import (
    HarnessError,
    NodeDiedError,
    RefusedError,
    WaitTimeoutError,
)
from rodless_lab.session.samples import LostSampleError, Sample, Samples
from rodless_lab.session.session import Mode, RigSession

__all__ = [
    "Alteration",
    "HarnessError",
    "Law",
    "LostSampleError",
    "Mode",
    "NodeDiedError",
    "RefusedError",
    "RigSession",
    "Sample",
    "Samples",
    "WaitTimeoutError",
]
