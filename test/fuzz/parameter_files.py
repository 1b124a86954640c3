# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Parameter files: good YAML, spoilt."""

from pathlib import Path

from changed_text import changed, drawn
from draw import Draw
from target import Change, Target

from rodless_base.parameter_file import section_names
from rodless_control import ControllerParameters
from rodless_sim import RigParameters

GOOD = """/**/plant:
  ros__parameters:
    supply.pressure: 0.6e6
    friction:
      form: saturating
      forward: {static: 30.0, coulomb: 12.0}
    valve.area_coefficients: [2.108, 0.1742, 2.012, 2.157, -0.0933, 0.9104, 0.1, 0.1, 0.1]
    sensors.seed: 7
    time.mode: lockstep
/**/controller:
  ros__parameters:
    controller: {kp: 700.0, ki: 50}
    reference.type: sine
/**:
  ros__parameters: {use_sim_time: true}
lab:
  left:
    plant:
      ros__parameters: {sensors.seed: 8}
"""

# Put in place of something good, or between two lines.
SNIPPETS = (
    "1e-5", ".inf", "-.nan", "190:20:30", "0o17", "0x1F", "1_000", "yes", "~", "''", '"', "'",
    "&a {x: 1}", "*a", "<<: *a", "!!python/object:os.system {}", "!!float abc", "!!binary aGk=",
    "!!set {a}", "!!timestamp 2001-01-01", "2001-01-01 00:00:00", "? a", "- 1", "[", "{", "]",
    "---", "...", "%YAML 9.9", "\t", "#", "|", ">", "@", "`", "\x00", "\x85", "\ufeff", "é",
    "ros__parameters:", "/**:", "supply.pressure: 1", "{" * 40, "[" * 30, "a: " * 30, "9" * 5000,
    "? [1, 2]\n: 3", "? {a: 1}\n: 3", "0.1: 5", "null: 5", "true: 5", "x" * 5000,
)  # fmt: skip


class ParameterFiles(Target):
    """A change is where in the text, how much of it goes, and what comes."""

    def __init__(self, folder: Path) -> None:
        """Choose the file."""
        super().__init__(folder)
        self._file = folder / "parameters.yaml"

    def draw(self, draw: Draw) -> list[Change]:
        """Return changes of texts; a byte that is no text, now and then."""
        return drawn(draw, GOOD, lambda: draw.choice((draw.choice(SNIPPETS), draw.text(), "")))

    def run(self, changes: list[Change]) -> object:
        """Read both sections."""
        self._file.write_bytes(changed(GOOD, changes))
        names = section_names(self._file)
        rig = RigParameters.from_file(self._file)
        controller = ControllerParameters.from_file(self._file)
        return [dict(rig), dict(controller), names]
