# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Plant and controller under a test: start, drive, disturb and record them, and clean up."""

from rodless_lab.session.commands import Alteration, Law
from rodless_lab.session.errors import (
    HarnessError,
    LawFailedError,
    NodeDiedError,
    RefusedError,
    WaitTimeoutError,
)
from rodless_lab.session.lag import LagWarning
from rodless_lab.session.live_session import Mode
from rodless_lab.session.samples import LostSampleError, Sample, Samples
from rodless_lab.session.session import RigSession
from rodless_lab.session.setpoint import SetpointWarning

PatienceError = WaitTimeoutError  # its old name

__all__ = [
    "Alteration",
    "HarnessError",
    "LagWarning",
    "Law",
    "LawFailedError",
    "LostSampleError",
    "Mode",
    "NodeDiedError",
    "PatienceError",
    "RefusedError",
    "RigSession",
    "Sample",
    "Samples",
    "SetpointWarning",
    "WaitTimeoutError",
]
