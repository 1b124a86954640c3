# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""How far long work is, said on stderr."""

import math
import sys
import time


class Progress:
    """Shows lines, one a second at the most."""

    def __init__(self) -> None:
        """Show the first line at once."""
        self._shown = -math.inf

    def show(self, line: str, last: bool = False) -> None:
        """Show ``line``, unless one was shown less than a second ago and it is not the ``last``."""
        if last or time.monotonic() - self._shown >= 1.0:
            self._shown = time.monotonic()
            print(line, file=sys.stderr, flush=True)
