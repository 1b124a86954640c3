# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What a node last published of itself on ``/diagnostics``."""

import difflib
import math
from collections.abc import Mapping
from typing import NamedTuple

from rodless_base.one_line import listed, shown
from rodless_lab.session.errors import HarnessError

# Of the largest count that is believed.
DIGITS = 9


class Diagnostic(NamedTuple):
    """One report: its level is one of DiagnosticStatus.OK, .WARN, .ERROR and .STALE."""

    level: bytes
    message: str
    values: dict[str, str]
    arrived: float = 0.0  # s, of time.monotonic()
    stamp: int = 0  # ns, of plant time

    def number(self, name: str, node: str) -> float:
        """Return a number among the values of ``node``; raises HarnessError for what is none."""
        if name not in self.values:
            counted = [one for one, text in self.values.items() if _is_number(text)]
            near = difflib.get_close_matches(str(name), counted, n=1)
            way_out = f"did you mean {near[0]!r}" if near else f"it counts {listed(counted)}"
            raise HarnessError(f"{node} counts no {shown(name)}; {way_out}")
        text = self.values[name]
        if not _is_number(text):
            raise HarnessError(f"{node}: {name} is {shown(text)}, no number")
        return float(text)


def number_among(values: Mapping[str, str], name: str, otherwise: float) -> float:
    """Return a finite number among ``values``, or ``otherwise`` where there is none.

    Whoever publishes diagnostics may write there what it likes.
    """
    text = values.get(name, "")
    number = float(text) if _is_number(text) else math.nan
    return number if math.isfinite(number) else otherwise


def count_among(values: Mapping[str, str], name: str) -> int:
    """Return a count among ``values``, 0 where there is none that anybody could have counted."""
    text = values.get(name, "")
    is_count = text.isascii() and text.isdecimal() and len(text) <= DIGITS
    return int(text) if is_count else 0


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
