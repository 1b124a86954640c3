# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Several kernels as one: chosen by a code, or added up."""

import json
import math
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest
from kernel_copy import copy_kernels
from unmeasured import unmeasured

from rodless_base.kernels import dispatch, kernel, total


class Line(NamedTuple):
    """Constants of the first."""

    slope: float


class Curve(NamedTuple):
    """Constants of the second."""

    size: float
    power: int


@kernel
def line(constants: Line, x: float, y: float) -> float:
    return constants.slope * x + y


@kernel
def curve(constants: Curve, x: float, y: float) -> float:
    return constants.size * x**constants.power - y


@kernel
def difference(constants: tuple[()], x: float, y: float) -> float:  # noqa: ARG001
    return x - y


CONSTANTS = (Line(3.0), Curve(0.5, 2), ())
ALONE = (3.0 * 4.0 + 10.0, 0.5 * 4.0**2 - 10.0, 4.0 - 10.0)
FUNCTIONS = (line, curve, difference)


@pytest.mark.parametrize("code", [0, 1, 2])
def test_a_code_chooses_one_and_its_constants(code: int) -> None:
    """Kernel k is called with entry k, whatever types the entries have; none is a tuple of none."""
    assert dispatch(FUNCTIONS)(code, CONSTANTS, 4.0, 10.0) == ALONE[code]


def test_all_are_added_up() -> None:
    """Each with its own entry, from the first to the last."""
    assert total(FUNCTIONS)(CONSTANTS, 4.0, 10.0) == sum(ALONE)


def test_nothing_adds_up_to_zero_and_sums_may_be_of_another_kind() -> None:
    """Without kernels the sum is the zero given; ``plus`` says how two results are added."""

    @kernel
    def plus(one: Line, other: Line) -> Line:
        return Line(one.slope + other.slope)

    @kernel
    def twice(constants: Line, x: float) -> Line:
        return Line(2.0 * constants.slope * x)

    zero = Line(0.0)
    assert total([], zero, plus)((), 3.0) == zero
    assert total([twice, twice], zero, plus)((Line(1.0), Line(10.0)), 3.0) == Line(66.0)


def test_one_is_enough() -> None:
    """A single kernel is itself, chosen or added up, to the sign of zero."""
    assert dispatch([line])(0, (Line(3.0),), 4.0, 10.0) == ALONE[0]
    assert math.copysign(1.0, total([line])((Line(-1.0),), 0.0, -0.0)) == -1.0


def test_a_kernel_that_calls_them_gives_the_same() -> None:
    """They are called from compiled code, with the code known only there."""
    choose, add = dispatch(FUNCTIONS), total(FUNCTIONS)

    @kernel
    def outer(constants: tuple[object, ...], x: float, y: float) -> float:
        found = add(constants, x, y)
        for code in range(3):
            found += choose(code, constants, x, y) * 10.0**code
        return found

    expected = sum(ALONE) + ALONE[0] + 10.0 * ALONE[1] + 100.0 * ALONE[2]
    assert outer(CONSTANTS, 4.0, 10.0) == pytest.approx(expected, rel=1e-15)


PROBE = """
from rodless_base import kernels
from rodless_base.kernels import dispatch, kernel, total

@kernel
def left(constants, x): {first}

@kernel
def right(constants, x): {second}

choose, add = dispatch([left, right]), total([left, right])

@kernel
def outer(code, x): return choose(code, (3.0, 5.0), x) + 100.0 * add((3.0, 5.0), x)
"""
ASK = (
    "import importlib, json, sys\n"
    "modules = [importlib.import_module(f'rodless_probe.{name}') for name in sys.argv[1:]]\n"
    "found = [module.outer(code, 7.0) for module in modules for code in (0, 1)]\n"
    "hits = sum(sum(module.outer.stats.cache_hits.values()) for module in modules)\n"
    "print(json.dumps([found, hits]))"
)


@pytest.mark.slow
def test_they_are_cached_with_the_kernel_that_calls_them(tmp_path: Path) -> None:
    """What two processes have compiled, a third takes from the cache, and mixes nothing up.

    The two modules join functions of the same types, in opposite order: the linker must tell the
    joined ones apart.
    """
    times, plus = "return constants * x", "return constants + x"
    # A package of kernels beside a copy of the base: others are not cached.
    copy_kernels(tmp_path)
    probe = tmp_path / "rodless_probe"
    probe.mkdir()
    (probe / "__init__.py").touch()
    for file, (first, second) in {"one": (times, plus), "other": (plus, times)}.items():
        text = PROBE.format(first=first, second=second)
        (probe / f"{file}.py").write_text(text, encoding="utf-8")
    environment = {
        **unmeasured(),
        "NUMBA_CACHE_DIR": str(tmp_path / "cache"),
        "PYTHONPATH": str(tmp_path),
    }

    def ask(*modules: str) -> list[object]:
        done = subprocess.run(
            [sys.executable, "-c", ASK, *modules],
            env=environment,
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        answer: list[object] = json.loads(done.stdout)
        return answer

    # Chosen: 3 · 7 or 5 + 7, and 3 + 7 or 5 · 7; a hundred times their sum beside it.
    one = [21.0 + 3300.0, 12.0 + 3300.0]
    other = [10.0 + 4500.0, 35.0 + 4500.0]
    assert ask("one") == [one, 0]
    assert ask("other") == [other, 0]
    assert ask("one", "other") == [one + other, 2]
