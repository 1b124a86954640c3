"""Plant and controller under a test: start, drive, disturb and record them, and clean up."""

from rodless_lab.harness.commands import Alteration, Law
from rodless_lab.harness.errors import (
    HarnessError,
    NodeDiedError,
    PatienceError,
    RefusedError,
)
from rodless_lab.harness.samples import LostSampleError, Sample, Samples
from rodless_lab.harness.session import Mode, RigSession

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
]
