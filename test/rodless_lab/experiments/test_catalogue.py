# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The list of experiments: one module, one line."""

import ast
import sys
from pathlib import Path
from types import ModuleType

import pytest

import rodless_lab.experiments
from rodless_lab.experiments import catalogue
from rodless_lab.experiments.experiment import Experiment

FOLDER = Path(rodless_lab.experiments.__file__).parent


def defines_an_experiment(file: Path) -> bool:
    """Whether a module assigns ``EXPERIMENT``."""
    return any(
        isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "EXPERIMENT"
        for node in ast.parse(file.read_text(encoding="utf-8")).body
    )


def test_every_module_with_an_experiment_is_listed_once() -> None:
    """A module that is forgotten in the list, or listed twice, would not be noticed otherwise."""
    there = [file.stem for file in FOLDER.glob("*.py") if defines_an_experiment(file)]
    assert sorted(there) == sorted(catalogue.MODULES)
    assert len(catalogue.EXPERIMENTS) == len(catalogue.MODULES)


def test_a_module_and_a_line_make_an_experiment(monkeypatch: pytest.MonkeyPatch) -> None:
    """What the list needs of a module is its EXPERIMENT, nothing else."""
    added = Experiment("mine", "Mine", "nowhere", "Nothing.", lambda _: None)
    module = ModuleType("rodless_lab.experiments.mine")
    module.EXPERIMENT = added
    monkeypatch.setitem(sys.modules, module.__name__, module)
    assert catalogue.experiments_of((*catalogue.MODULES, "mine"))["mine"] is added
