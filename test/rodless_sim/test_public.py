# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What a newcomer sees of the package first: dir, help, and examples that run."""

import doctest
import pydoc
from collections.abc import Callable

import pytest

import rodless_sim
from rodless_sim import Rig, RigParameters, State, Trace, simulate

# Lines of a terminal.
SCREEN = 24


def page(thing: object) -> str:
    """What help() shows of something."""
    return pydoc.plain(pydoc.render_doc(thing))


def test_dir_shows_what_is_public() -> None:
    """dir() lists the names of __all__ and no others, and each is there."""
    assert dir(rodless_sim) == sorted(rodless_sim.__all__)
    assert all(hasattr(rodless_sim, name) for name in rodless_sim.__all__)
    assert len(rodless_sim.__all__) >= 6


@pytest.mark.parametrize("name", rodless_sim.__all__)
def test_every_public_object_has_an_example_that_runs(name: str) -> None:
    """It is shown by help() and gives what it says."""
    thing = getattr(rodless_sim, name)
    finder = doctest.DocTestFinder(recurse=False)
    tests = [test for test in finder.find(thing, name, globs={}) if test.examples]
    assert len(tests) == 1, name
    result = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(tests[0])
    assert result.attempted > 0
    assert result.failed == 0
    assert ">>> " in page(thing)


@pytest.mark.parametrize(
    "method",
    [
        Rig.configure,
        RigParameters.preset,
        RigParameters.from_file,
        RigParameters.with_values,
        RigParameters.number,
    ],
)
def test_methods_for_beginners_have_examples_that_run(method: Callable[..., object]) -> None:
    """What help() of each shows gives what it says."""
    (test,) = doctest.DocTestFinder(recurse=False).find(method, method.__name__)
    result = doctest.DocTestRunner().run(test)
    assert result.attempted > 0
    assert result.failed == 0


@pytest.mark.parametrize("thing", [simulate, Rig, Trace, Rig.advance, Rig.reset, Rig.read])
def test_help_opens_with_what_it_does(thing: object) -> None:
    """The first screen names no array types of numpy's own making."""
    first = "\n".join(page(thing).splitlines()[:SCREEN])
    for noise in ("numpy._typing", "numpy.dtype", "_SupportsArray", "ndarray["):
        assert noise not in first


def test_help_of_simulate_says_what_it_takes_and_gives() -> None:
    """Each parameter by name, what comes back, and what is refused."""
    text = page(simulate)
    for word in ("Parameters", "voltages", "period", "position, pressures", "Returns", "Raises"):
        assert word in text


def test_help_of_a_state_gives_meaning_and_unit_of_each_field() -> None:
    """Not "Alias for field number 3"."""
    text = page(State)
    assert "Alias for field" not in text
    assert "pneumatic force on the carriage, A (P_a − P_b), N" in text


def test_advance_points_to_what_the_instruments_read() -> None:
    """It returns the true state, and says so."""
    assert "true state" in page(Rig.advance)
    assert "read" in page(Rig.advance)
