# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Compile the equations of a rig in a process of its own, for others to load.

Run as a program it reads one line of JSON from standard input: the parameters of a rig, and those
it is to change to. It ends early where standard input does, with the process that started it.
"""

import json
import os
import sys
import threading
from collections.abc import Mapping

from rodless_sim.parameters import RigParameters
from rodless_sim.rig import Rig

# Of a process beside one that keeps time.
NICENESS = 10

STANDARD_INPUT = 0


def change_rig(before: Mapping[str, object], after: Mapping[str, object]) -> None:
    """Change a rig from one set of parameters to another, and run and read it."""
    rig = Rig(RigParameters(before))
    rig.configure(RigParameters(after))
    rig.advance(rig.state.voltage, 1e-3)
    rig.read()


def _end_with_standard_input() -> None:
    # Not by sys.stdin, which a thread that waits for it keeps from being closed at the end.
    while os.read(STANDARD_INPUT, 1):
        pass
    os._exit(1)


def main() -> None:
    """Do what the line says."""
    os.nice(NICENESS)
    before, after = json.loads(sys.stdin.readline())
    threading.Thread(target=_end_with_standard_input, daemon=True).start()
    change_rig(before, after)


if __name__ == "__main__":
    main()
