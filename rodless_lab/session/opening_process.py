# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The process that has opened a session: what is forked from it has no part in the session."""

import os

from rodless_lab.session.errors import HarnessError


class OpeningProcess:
    """The process that this object was made in."""

    def __init__(self) -> None:
        """Remember this process."""
        self._pid = os.getpid()

    @property
    def is_this(self) -> bool:
        """Whether this process is the one, and none that was forked from it."""
        return os.getpid() == self._pid

    def check(self) -> None:
        """Raise HarnessError in a process that was forked from it."""
        if not self.is_this:
            raise HarnessError(
                "this process was forked inside the block of a session, which only the process "
                "that opened it can use; open one here, or leave the session alone"
            )
