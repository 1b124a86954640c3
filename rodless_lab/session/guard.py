# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""End the processes of a session whose own process was killed.

Run as a program of its own: it reads process IDs, each the leader of a process group, from
standard input, ``+`` before one to watch and ``-`` before one that has ended. Standard input ends
with the process that holds the other side of it, however that ends; what is still watched then
is asked to stop, and killed where it does not.
"""

import contextlib
import os
import select
import signal
import sys
import time
from collections.abc import Collection

# From the request to stop to the end by force, in s.
TIMEOUT = 5.0
POLL = 0.02


def end(groups: Collection[int]) -> None:
    """Stop process groups: SIGINT first, as Ctrl-C does, then SIGKILL.

    One that cannot be ended keeps no other from it.
    """
    leaders = {}
    for group in groups:
        with contextlib.suppress(OSError):  # a leader that has ended, which its group has not
            leaders[group] = os.pidfd_open(group)
        # Only what runs can act on a signal.
        _signal(group, signal.SIGCONT)
        _signal(group, signal.SIGINT)
    deadline = time.monotonic() + TIMEOUT
    for leader in leaders.values():
        select.select([leader], [], [], max(deadline - time.monotonic(), 0.0))
    leaderless = [group for group in groups if group not in leaders]
    while any(_signal(group, 0) for group in leaderless) and time.monotonic() < deadline:
        time.sleep(POLL)
    for group in groups:
        _signal(group, signal.SIGKILL)


def _signal(group: int, number: int) -> bool:
    """Send a signal to a group; return whether there is one to take it."""
    try:
        os.killpg(group, number)
    except OSError:
        return False
    return True


def main() -> None:
    """Watch until standard input ends."""
    groups: set[int] = set()
    for line in sys.stdin:
        change = groups.add if line[0] == "+" else groups.discard
        change(int(line[1:]))
    end(groups)


if __name__ == "__main__":
    main()
