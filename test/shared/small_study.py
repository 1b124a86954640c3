# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A small study, and a law in Python that notes which rows it has run."""

from pathlib import Path

STUDY = """
base: calibrated
sensors: data-sheet
set: {{reference.at: 0.02, controller.law: "{law}"}}
vary:
  cylinder.moving_mass: {{from: 0.7, to: 2.0}}
  friction.*.static: {{from: 0.8, to: 1.2, factor: true}}
design: {{method: sobol, rows: {rows}, seed: 7}}
run: {{duration: {duration}}}
traces: {{columns: [position, voltage], every: 20}}
"""

# The noise of the first reading tells the rows apart: each has a seed of its own.
LAW = """
import os
import threading
from rodless_control import Law


class Noted(Law):
    begun = False

    def reset(self):
        self.begun = False

    def update(self, measurement, reference, interval):
        if not self.begun:
            self.begun = True
            with open(os.environ["NOTED"], "a+") as file:
                file.write(f"{measurement[1:]!r}\\n")
                file.seek(0)
                rows = len(file.readlines())
            if rows == int(os.environ.get("HELD_AT", 0)):
                threading.Event().wait()
        return 5.08 + 100.0 * (reference.position - measurement.position)
"""


def write_study(folder: Path, law: str = "pid", rows: int = 20, duration: float = 0.1) -> Path:
    """Write the study and return its file."""
    path = folder / "small.yaml"
    path.write_text(STUDY.format(law=law, rows=rows, duration=duration), encoding="utf-8")
    return path


def write_law(folder: Path) -> str:
    """Write the law that notes its rows in the file ``NOTED``; return what controller.law calls it.

    It never answers in row ``HELD_AT``, counted from 1, where the environment has that. ``folder``
    must be on the path of whoever runs it.
    """
    (folder / "noted_law.py").write_text(LAW, encoding="utf-8")
    return "noted_law:Noted"
