# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Scenario files: good YAML, spoilt, and a rig that follows what is left."""

from pathlib import Path

from changed_text import changed, drawn
from draw import Draw
from parameter_files import SNIPPETS
from target import Change, Target

from rodless_sim import RigParameters, Scenario, simulate

GOOD = """# A comment
- at: 0.01
  fault.piston.leak: 5.0e-9
  fault: {valve: {offset: 0.2, spool: stuck}}
- {at: 0.02, fault.supply.loss: 1, sensors.delay: 1e-3}
- at: 0.03
  fault.carriage.seized: true
  supply.pressure: 500000
  valve.flow_law: iso_6358
"""

NUMBERS = ("-1", "0", "1e-9", "1e300", "1e6", "0.02", "10", "true", "[1, 2]", "stuck_at", "gone")

RIG = RigParameters.preset("paper")


class ScenarioFiles(Target):
    """A change is where in the text, how much of it goes, and what comes."""

    def __init__(self, folder: Path) -> None:
        """Choose the file."""
        super().__init__(folder)
        self._file = folder / "scenario.yaml"

    def draw(self, draw: Draw) -> list[Change]:
        """Return changes of texts; names and numbers that may be good, now and then."""

        def new() -> str:
            names = draw.choice((*RigParameters(), *NUMBERS))
            return draw.choice((draw.choice(SNIPPETS), draw.text(), names, ""))

        return drawn(draw, GOOD, new)

    def run(self, changes: list[Change]) -> object:
        """Read it, and let a rig follow it."""
        self._file.write_bytes(changed(GOOD, changes))
        scenario = Scenario.from_file(self._file)
        run = simulate(RIG, [6.0] * 8, 5e-3, scenario=scenario)
        return [[entry.text for entry in scenario.entries], run.columns()]
