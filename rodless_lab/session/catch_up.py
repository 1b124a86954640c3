# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Whether a test has heard all that its rig has sent while it computed."""

import time

from rodless_lab.session.samples import Received

# Wall-clock s: a plant of which nothing has come for so long stands still, unless it was paused,
# and where it was; and the longest time to catch up with one that runs on. A plant that has waited
# for the test, whose queue was full, takes a while to go on.
STANDSTILL = 0.5
PAUSED_STANDSTILL = 0.04
CATCH_UP_TIMEOUT = 10.0


class CatchUp:
    """Follows what is ``received`` until all has come that was sent before this was made."""

    def __init__(self, received: Received, paused: bool) -> None:
        """Begin with what has come so far, of a plant that may be ``paused``."""
        self._received = received
        self._standstill = PAUSED_STANDSTILL if paused else STANDSTILL
        self.until = time.time_ns()  # of the wall clock
        self._newest = received.last_sent
        self._heard = time.monotonic()
        self._deadline = self._heard + CATCH_UP_TIMEOUT

    def is_over(self) -> bool:
        """Whether all is there, or no more comes; to be asked after each look at what has come."""
        now, newest = time.monotonic(), self._received.last_sent
        if newest != self._newest:
            self._newest, self._heard = newest, now
        stands = now - self._heard > self._standstill
        return stands or now > self._deadline or self._received.last_complete_sent >= self.until
