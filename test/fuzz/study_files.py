# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Study and tuning files: good YAML, spoilt, and what is left read as far as a run would."""

from pathlib import Path

from changed_text import changed, drawn
from draw import Draw
from parameter_files import SNIPPETS
from target import Change, Target

from rodless_control import ControllerParameters
from rodless_lab.simulation.run_metrics import RunMetrics
from rodless_lab.studies.study import DESIGNS, TRACES, read_study
from rodless_lab.studies.tuning_task import read_task
from rodless_sim import RigParameters

STUDY = """# A comment
base: calibrated
sensors: data-sheet
set: {reference.type: step, reference.target: 0.058, reference.at: 0.01}
vary:
  friction.*.static: {from: 0.6, to: 1.4, factor: true}
  supply.pressure: {from: 5e5, to: 7e5, scale: logarithmic}
  cylinder.model: [CY3R25-200, CY3R32-300]
design: {method: sobol, rows: 2, seed: 1}
traces: {columns: [position], every: 5}
run: {duration: 0.02, period: 1e-3, since: 0.0}
"""

TUNING = """tune:
  controller.kp: {from: 100.0, to: 2000.0, scale: logarithmic}
  controller.ki: {from: 5.0, to: 300.0}
score: {quantile: 0.9, figures: {settling_time: 1.0, mean_error: 1.0e-4}}
search: {generations: 2, population: 2, seed: 1}
"""

# A study of millions of rows is none that is wrong, but its check takes its time.
NUMBERS = ("-1", "0", "1e-9", "1e300", "0.5", "true", "[]", "[1, 2]", "{}", "''", "1", "3")

NAMES = (*RigParameters(), *ControllerParameters(), *RunMetrics._fields, *DESIGNS, *TRACES)


class StudyFiles(Target):
    """A change is which file, or where in its text, how much of it goes, and what comes."""

    def __init__(self, folder: Path) -> None:
        """Choose the file."""
        super().__init__(folder)
        self._file = folder / "study.yaml"

    def draw(self, draw: Draw) -> list[Change]:
        """Return changes of texts; names and numbers that may be good, now and then."""
        tuning = draw.random() < 0.5

        def new() -> str:
            known = draw.choice((draw.choice(NAMES), draw.choice(NUMBERS)))
            return draw.choice((draw.choice(SNIPPETS), draw.text(), known, known, ""))

        return ["tuning"] * tuning + drawn(draw, STUDY + TUNING * tuning, new)

    def run(self, changes: list[Change]) -> object:
        """Read it, and make its rigs."""
        tuning = "tuning" in changes
        texts = [change for change in changes if change != "tuning"]
        self._file.write_bytes(changed(STUDY + TUNING * tuning, texts))
        if not tuning:
            study = read_study(self._file)
            return [dict(study.row(len(study) - 1).base.rig), study.numbers]
        task = read_task(self._file)
        return [task.values(task.present_shares), task.present()]
