"""Several kernels as one: chosen by a code, or added up."""

import json
import math
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest

from rodless_base import kernels
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
from rodless_base.kernels import dispatch, kernel, total

@kernel
def {first}(constants, x): return constants * x

@kernel
def {second}(constants, x): return constants + x

choose, add = dispatch([{first}, {second}]), total([{first}, {second}])

@kernel
def outer(code, x): return choose(code, (3.0, 5.0), x) + 100.0 * add((3.0, 5.0), x)
"""
ASK = (
    "import json\nfrom rodless_probe import one, other\n"
    "hits = lambda: sum(sum(m.outer.stats.cache_hits.values()) for m in (one, other))\n"
    "found = [m.outer(c, 7.0) for m in (one, other) for c in (0, 1)]\n"
    "print(json.dumps([found, hits()]))"
)


def test_they_are_cached_with_the_kernel_that_calls_them(tmp_path: Path) -> None:
    """A second process takes both modules from the cache and mixes nothing up.

    The two join functions of the same types, in opposite order; the linker must keep them apart.
    """
    # A package of kernels beside a copy of the base: others are not cached.
    (tmp_path / "rodless_base").mkdir()
    for name in ("__init__.py", "kernels.py"):
        shutil.copy(Path(kernels.__file__).parent / name, tmp_path / "rodless_base")
    probe = tmp_path / "rodless_probe"
    probe.mkdir()
    (probe / "__init__.py").touch()
    (probe / "one.py").write_text(PROBE.format(first="times", second="plus"))
    swapped = PROBE.format(first="plus", second="times")
    swapped = swapped.replace("def plus(constants, x): return constants * x", "MARK")
    swapped = swapped.replace(
        "def times(constants, x): return constants + x",
        "def times(constants, x): return constants * x",
    ).replace("MARK", "def plus(constants, x): return constants + x")
    (probe / "other.py").write_text(swapped)
    environment = {
        **{name: value for name, value in os.environ.items() if not name.startswith("COV")},
        "NUMBA_CACHE_DIR": str(tmp_path / "cache"),
        "PYTHONPATH": str(tmp_path),
    }
    answers = []
    for _ in range(2):
        done = subprocess.run(
            [sys.executable, "-c", ASK],
            env=environment,
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        answers.append(json.loads(done.stdout))
    one = [21.0 + 100.0 * 33.0, 12.0 + 100.0 * 33.0]
    # Constants stay with their place: 3 + x, 5 x.
    other = [10.0 + 100.0 * 45.0, 35.0 + 100.0 * 45.0]
    assert [found for found, _ in answers] == [one + other] * 2
    assert [hits for _, hits in answers] == [0, 2]
