# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The nodes in lock-step; in the middle of the run the seals run dry. Needs ROS.

The run is the same to the last bit each time, on any machine.

python examples/friction_fault.py [run.csv]
"""

import sys

from rodless_lab.harness import RigSession

DRY = {"friction.forward.static": 60.0, "friction.reverse.static": 67.0}  # N


def main(path: str) -> None:
    """Move to 58 mm, let the seals run dry, move back to 20 mm."""
    # The commands pass through this program, so the plant waits for it at 2 s.
    with RigSession("lockstep", preset="calibrated", duration=6.0, relay_commands=True) as rig:
        rig.setpoint(0.058)
        rig.run_until(2.0)
        print(f"2 s: {1e3 * rig.latest.position:.2f} mm")
        rig.set_parameters("plant", DRY)
        rig.setpoint(0.020)
        run = rig.run()
    print(f"6 s: {1e3 * run.position[-1]:.2f} mm")
    run.save(path)


if __name__ == "__main__":  # the session starts processes, which import this file
    main(sys.argv[1] if len(sys.argv) > 1 else "friction_fault.csv")
