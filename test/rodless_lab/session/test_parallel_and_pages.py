# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Several tests at once, the template folder, and the examples of the docs, as a user runs them."""

import os
import re
import shutil
import subprocess
import textwrap
from collections.abc import Callable
from pathlib import Path

import pytest
from extent import draws, extensive

pytestmark = [pytest.mark.usefixtures("compiled"), pytest.mark.slow]

ROOT = Path(__file__).resolve().parents[3]

# For a process of a test to end, in wall-clock s.
TIMEOUT = 500.0

RunPytest = Callable[..., subprocess.Popen[str]]

AT_ONCE = draws(8, 3)

# More rounds than CI needs: RODLESS_HARNESS_ROUNDS=20.
ROUNDS = int(os.environ.get("RODLESS_HARNESS_ROUNDS", "1"))

# Each has a target of its own: a rig that heard another one would miss it.
ONE_OF_MANY = """
    def test_my_own_target(rig_session):
        target = 0.002 * (1 + {number})
        step = {{"reference.type": "step", "reference.at": 0.01, "reference.target": target}}
        rig = rig_session("lockstep", duration=1.5, controller=step)
        run = rig.run()
        assert len(run) == 1501
        assert abs(run.position[-1] - target) < 5e-4
        rig.reset()
        rig.run_until(0.1)

    def test_my_own_set_point(rig_session):
        target = 0.002 * (1 + {number})
        rig = rig_session(plant={{"time.period": 0.01}})
        rig.setpoint(target)
        rig.run_until(lambda sample: abs(sample.position - target) < 5e-4, "the target")
        run = rig.samples()
        assert run.position.max() < target + 1.5e-3
"""


@pytest.mark.parametrize("round_number", range(ROUNDS))
def test_many_at_once_do_not_hear_each_other(
    tmp_path: Path, run_pytest: RunPytest, round_number: int
) -> None:
    """Runs of pytest at the same time, each with rigs and targets of its own, all pass."""
    del round_number
    for number in range(AT_ONCE):
        text = textwrap.dedent(ONE_OF_MANY).format(number=number)
        (tmp_path / f"test_{number}.py").write_text(text, encoding="utf-8")
    running = [
        run_pytest(f"test_{number}.py", f"--basetemp={tmp_path}/tmp{number}")
        for number in range(AT_ONCE)
    ]
    outputs = [process.communicate(timeout=TIMEOUT)[0] for process in running]
    assert [process.returncode for process in running] == [0] * AT_ONCE, "\n".join(outputs)


def test_the_template_folder_works_where_it_is_copied_to(
    tmp_path: Path, run_pytest: RunPytest
) -> None:
    """Its test passes with its example controller, far from this project."""
    shutil.copytree(ROOT / "templates" / "controller_test", tmp_path / "mine")
    process = run_pytest("mine")
    output = process.communicate(timeout=TIMEOUT)[0]
    assert process.returncode == 0, output
    assert " passed" in output


@extensive
def test_the_template_test_can_fail(tmp_path: Path, run_pytest: RunPytest) -> None:
    """With the example controller's sign turned round, the carriage misses the target."""
    shutil.copytree(ROOT / "templates" / "controller_test", tmp_path / "mine")
    controller = tmp_path / "mine" / "example_controller.py"
    text = controller.read_text(encoding="utf-8")
    assert "CLOSED_VOLTAGE + self.gain" in text
    controller.write_text(text.replace("CLOSED_VOLTAGE + self", "CLOSED_VOLTAGE - self"))
    process = run_pytest("mine", "-k", "reaches_the_set_point and plain")
    output = process.communicate(timeout=TIMEOUT)[0]
    assert process.returncode == 1, output
    assert "output of rig 0: controller" in output


@extensive
def test_the_examples_of_the_page_run(tmp_path: Path, run_pytest: RunPytest) -> None:
    """Each block of Python in docs/harness.md that holds tests passes as it stands."""
    page = (ROOT / "docs" / "harness.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    examples = [block for block in blocks if "def test_" in block and "launch" not in block]
    assert len(examples) >= 2
    for number, block in enumerate(examples):
        (tmp_path / f"test_example_{number}.py").write_text(block, encoding="utf-8")
    process = run_pytest()
    output = process.communicate(timeout=TIMEOUT)[0]
    assert process.returncode == 0, output
    assert f"{sum(block.count('def test_') for block in examples)} passed" in output
