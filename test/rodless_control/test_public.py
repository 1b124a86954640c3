# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What the package shows: its names, and an example for each that runs."""

import doctest

import pytest

import rodless_control


def test_dir_shows_what_is_public_and_nothing_else() -> None:
    """dir() lists the names of __all__, and each is there."""
    assert dir(rodless_control) == sorted(rodless_control.__all__)
    assert all(hasattr(rodless_control, name) for name in rodless_control.__all__)


@pytest.mark.parametrize("name", rodless_control.__all__)
def test_every_public_object_has_an_example_that_runs(name: str) -> None:
    """help() of each shows an example, and what it prints is what it says."""
    thing = getattr(rodless_control, name)
    scope = vars(rodless_control) | (vars(thing) if name == "references" else {})
    example = doctest.DocTestParser().get_doctest(thing.__doc__ or "", scope, name, None, None)
    assert example.examples
    report: list[str] = []
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS)
    assert runner.run(example, out=report.append).failed == 0, "".join(report)
