# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The examples that help() shows of the public objects, run as they stand."""

import doctest
import importlib
from pathlib import Path

import numpy as np
import pytest
from extent import also
from rig_bag import write

import rodless_lab
from rodless_lab import identification
from rodless_lab.runs.measured_run import run_of_trace
from rodless_sim import RigParameters, simulate

# Classes of results, which a function makes, are shown by its example.
EXAMPLES = [
    *(("rodless_lab", name) for name in ("Bag", "MeasuredRun", "TopicMessages")),
    *(("rodless_lab", name) for name in ("read_bag", "read_commands", "read_run")),
    *(
        ("rodless_lab.identification", name)
        for name in identification.__all__
        if name.islower() and name != "identify_bristles"
    ),
    also("rodless_lab.identification", "identify_bristles"),
]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with a bag named run1: 0.1 s from rest at 0."""
    run = run_of_trace(simulate(RigParameters(), np.full(100, 5.1), 1e-3), 6e5)
    monkeypatch.chdir(tmp_path)
    return write(tmp_path / "run1", run).parent


@pytest.mark.parametrize(("package", "name"), EXAMPLES, ids=lambda value: value)
def test_examples_run(folder: Path, package: str, name: str) -> None:
    """There is an example, and it gives what it says."""
    found = getattr(importlib.import_module(package), name)
    module = importlib.import_module(found.__module__)
    (test,) = doctest.DocTestFinder(recurse=False).find(found, name, module)
    assert test.examples
    outcome = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE).run(test)
    assert outcome.failed == 0
    assert folder.exists()


def test_every_public_name_says_what_it_is() -> None:
    """No public object without a docstring of its own."""
    for package in (rodless_lab, identification):
        for name in package.__all__:
            assert getattr(package, name).__doc__, name
