# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Compiled kernels: kept between processes, and never kept too long."""

import inspect
import json
import math
import os
import shutil
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple, get_args, get_type_hints

import numba
import numpy as np
import pytest
from extent import extensive
from kernel_copy import copy_kernels
from unmeasured import unmeasured

import rodless_base
import rodless_sim
from rodless_base import kernels
from rodless_control import Measurement, Pid, PidParameters, ReferencePoint
from rodless_control.laws.pid import Gains, Memory
from rodless_sim import RigParameters
from rodless_sim.instruments.instruments import Instruments
from rodless_sim.physics.lands import Lands
from rodless_sim.physics.plant import Plant

INNER = "@kernel\ndef {name}(x):\n    return x * {factor}\n"
IMPORT = "from rodless_base.kernels import kernel\n"
OUTER = IMPORT + (
    "from rodless_probe.deep.inner import deep\nfrom rodless_probe.inner import near\n\n\n"
    "@kernel\ndef outer(x):\n    return near(x) + deep(x)\n"
)
ASK = (
    "from rodless_probe.outer import outer\nprint(outer(1.0), sum(outer.stats.cache_hits.values()))"
)
SAMPLES = [
    (Measurement(0, 0.001 * math.cos(k)), ReferencePoint(0.002 * math.sin(k), 0.01), 0.01)
    for k in range(50)
]


def inner(x: float) -> float:
    """What :func:`one_more` calls unless it is linked."""
    return x


def one_more(x: float) -> float:
    """One more than what :func:`inner` gives."""
    return inner(x) + 1.0


def environment(**changes: str) -> dict[str, str]:
    """Return this process's environment with ``changes``, without measuring coverage.

    Bytecode would be taken for fresh when a source changes twice within a second.
    """
    return {**unmeasured(), "PYTHONDONTWRITEBYTECODE": "1", **changes}


def output(code: str, variables: dict[str, str], folder: Path | None = None) -> str:
    """Run ``code`` in another Python, in ``folder``, and return what it prints."""
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=variables,
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


class Probe:
    """A small package of kernels beside a copy of the decorator, changed between processes."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        (folder / "rodless_probe" / "deep").mkdir(parents=True)
        copy_kernels(folder)
        for package in ("rodless_probe", "rodless_probe/deep"):
            (folder / package / "__init__.py").touch()
        (folder / "rodless_probe" / "outer.py").write_text(OUTER, encoding="utf-8")
        self.write("inner.py", "near", 2.0)
        self.write("deep/inner.py", "deep", 10.0)

    def write(self, file: str, name: str, factor: float) -> None:
        """Let the kernel ``name`` in ``file`` multiply by ``factor``."""
        text = IMPORT + "\n\n" + INNER.format(name=name, factor=factor)
        (self._folder / "rodless_probe" / file).write_text(text, encoding="utf-8")

    def ask(self, **variables: str) -> tuple[float, int]:
        """What a new process gets from the outer kernel, and how much of it came from a cache."""
        found = environment(PYTHONPATH=str(self._folder), **variables)
        result, hits = output(ASK, found, self._folder).split()
        return float(result), int(hits)


@pytest.fixture
def probe(tmp_path: Path) -> Probe:
    """Return kernels of which one calls two others, in a folder and in a folder below."""
    return Probe(tmp_path)


@pytest.mark.slow
def test_a_second_process_reuses_the_result_until_a_source_changes(
    probe: Probe, tmp_path: Path
) -> None:
    """A change of a called function, in a folder or below, is seen by the next process."""
    cache = {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    assert probe.ask(**cache) == (12.0, 0)
    assert probe.ask(**cache) == (12.0, 1)
    probe.write("inner.py", "near", 3.0)
    assert probe.ask(**cache) == (13.0, 0)
    probe.write("deep/inner.py", "deep", 20.0)
    assert probe.ask(**cache) == (23.0, 0)


PLANT = (
    "from rodless_sim import RigParameters\n"
    "from rodless_sim.instruments.instruments import truth\n"
    "from rodless_sim.physics.plant import Plant\nfrom rodless_sim.physics.state import Motion\n"
    "plant = Plant.of(RigParameters({'supply.pressure': 6e5, 'atmosphere.pressure': 1e5}))\n"
    "read = truth(plant, 0, Motion(0.1, 0.0, 2e5, 3e5))\n"
    "print(read.supply_pressure, sum(truth.stats.cache_hits.values()))"
)


@pytest.mark.slow
@extensive
def test_a_field_that_moves_in_a_named_tuple_gives_another_cache(tmp_path: Path) -> None:
    """Two pressures of Plant change places, in a file without kernels: none is taken for another.

    Compiled code finds fields by their place, and to numba the type is the same.
    """
    for package in (rodless_base, rodless_sim):
        source = Path(package.__file__).parent
        shutil.copytree(source, tmp_path / source.name)
    config = Path(rodless_base.__file__).parents[1] / "config"
    if config.is_dir():
        shutil.copytree(config, tmp_path / "config")
    others = os.pathsep.join([str(tmp_path), *(path for path in sys.path if path)])
    variables = environment(PYTHONPATH=others, NUMBA_CACHE_DIR=str(tmp_path / "cache"))
    assert output(PLANT, variables, tmp_path).split() == ["600000.0", "0"]
    assert output(PLANT, variables, tmp_path).split() == ["600000.0", "1"]
    file = tmp_path / "rodless_sim" / "physics" / "plant.py"
    text = file.read_text(encoding="utf-8")
    supply, ambient = (f"    {name}_pressure: float  # Pa" for name in ("supply", "ambient"))
    assert text.count(supply) == text.count(ambient) == 1
    swapped = text.replace(supply, "\0").replace(ambient, supply).replace("\0", ambient)
    file.write_text(swapped, encoding="utf-8")
    assert output(PLANT, variables, tmp_path).split() == ["600000.0", "0"]


def named_tuples(thing: object) -> Iterator[type]:
    """All named tuples that ``thing``, a value or a type, is made of."""
    if isinstance(thing, tuple):
        for item in thing:
            yield from named_tuples(item)
        thing = type(thing)
    for part in get_args(thing):
        yield from named_tuples(part)
    if isinstance(thing, type) and hasattr(thing, "_fields"):
        yield thing
        for hint in get_type_hints(thing).values():
            yield from named_tuples(hint)


def test_the_cache_depends_on_every_named_tuple_that_kernels_take() -> None:
    """A change of any of their files gives another cache."""
    plant = Plant.of(RigParameters())
    instruments = Instruments.specimen(RigParameters(), np.random.default_rng(1))
    found = set(named_tuples((plant, instruments, Lands, Gains, Memory, ReferencePoint)))
    found |= {Measurement}
    names = {kind.__name__ for kind in found}
    assert {"Air", "Edge", "Friction", "Direction", "Transmitter", "Plant", "Memory"} <= names
    watched = {path.resolve() for path in kernels._KERNEL_SOURCES}
    assert {kind for kind in found if Path(inspect.getfile(kind)).resolve() not in watched} == set()


@pytest.mark.slow
def test_results_are_kept_in_the_user_s_cache(probe: Probe, tmp_path: Path) -> None:
    """XDG_CACHE_HOME is where they go, nothing is written beside the sources."""
    where = {"NUMBA_CACHE_DIR": "", "XDG_CACHE_HOME": str(tmp_path / "user")}
    assert probe.ask(**where) == (12.0, 0)
    assert any((tmp_path / "user" / "rodless_sim").rglob("*.nbi"))
    assert not any((tmp_path / "rodless_probe").rglob("*.nbi"))


WITHOUT_A_HOME = """
import pathlib
def none():
    raise RuntimeError("Could not determine home directory.")
pathlib.Path.home = none
from rodless_base import kernels
print(kernels._CACHE_FOLDER)
"""


def test_a_user_without_a_home_compiles_in_memory(tmp_path: Path) -> None:
    """As some containers have it: one line says so, and a folder that is given is used."""
    for given in ("", str(tmp_path)):
        done = subprocess.run(
            [sys.executable, "-c", WITHOUT_A_HOME],
            env={**unmeasured(), "XDG_CACHE_HOME": "", "NUMBA_CACHE_DIR": given},
            capture_output=True,
            text=True,
            check=True,
        )
        if given:
            assert done.stdout.startswith(given)
            assert done.stderr == ""
        else:
            assert done.stdout == "None\n"
            assert done.stderr.splitlines()[-1].endswith(
                "each start compiles anew: Could not determine home directory."
            )


def test_other_users_of_numba_keep_their_cache(monkeypatch: pytest.MonkeyPatch) -> None:
    """Decorating leaves numba's own setting alone, whatever it was, and when it fails too."""
    monkeypatch.setattr(numba.config, "CACHE_DIR", "/somewhere/else")

    @kernels.kernel
    def half(x: float) -> float:
        return x / 2.0

    assert numba.config.CACHE_DIR == "/somewhere/else"
    assert half(3.0) == 1.5
    for wrong in (3, half):
        with pytest.raises(TypeError, match="is not a plain function"):
            kernels.kernel(wrong)  # type: ignore[type-var]
    assert numba.config.CACHE_DIR == "/somewhere/else"


def test_the_plain_python_function_is_at_hand() -> None:
    """The uncompiled original gives the same, and divides by zero as compiled code does."""

    @kernels.kernel
    def share(x: float, y: float) -> float:
        return x / y

    assert share.py_func(1.0, 4.0) == share(1.0, 4.0) == 0.25  # type: ignore[attr-defined]
    assert share(1.0, 0.0) == math.inf


def test_a_direct_call_is_the_same_function_for_one_set_of_types() -> None:
    """It gives what the kernel gives, takes integers for reals, and None for no number."""

    @kernels.kernel
    def fraction(x: float, y: float) -> float:
        return x / y

    quick = kernels.specialise(fraction, 1.0, 1.0)
    assert quick(1.0, 3.0) == fraction(1.0, 3.0) == 1.0 / 3.0
    assert quick(1, 4) == 0.25
    with pytest.raises(TypeError):
        quick(None, 4.0)
    assert fraction.signatures == [(numba.float64, numba.float64)]  # type: ignore[attr-defined]


def test_what_compiled_code_calls_is_not_made_for_python() -> None:
    """Of the inner kernel there is only what its caller needs, until Python calls it itself."""

    @kernels.kernel
    def inner(x: float) -> float:
        return x + 1.0

    @kernels.outlined_kernel
    def outer(x: float) -> float:
        return 2.0 * inner(x)

    near: Any = inner
    assert outer(1.0) == 4.0
    assert near.signatures == []
    assert near.inner.signatures == [(numba.float64,)]
    assert inner(1.0) == 2.0
    assert near.signatures == [(numba.float64,)]


def test_a_linked_copy_calls_what_it_is_given() -> None:
    """Copies of one function around two kernels are two functions, and the original stays."""

    @kernels.kernel
    def double(x: float) -> float:
        return 2.0 * x

    @kernels.kernel
    def half(x: float) -> float:
        return x / 2.0

    twice, halves = (kernels.linked(one_more, inner=inner) for inner in (double, half))
    assert (twice(3.0), halves(3.0), one_more(3.0)) == (7.0, 2.5, 4.0)
    assert kernels.unlinked(one_more, inner=math.sqrt)(9.0) == 4.0


@pytest.mark.slow
def test_what_runs_long_lets_other_threads_run() -> None:
    """An outlined kernel, and a linked one, release the GIL: Python counts on beside them."""

    @kernels.outlined_kernel
    def sum_to(count: int) -> float:
        total = 0.0
        for k in range(count):
            total += math.sin(k)
        return total

    sum_to(1)
    thread = threading.Thread(target=sum_to, args=(100_000_000,))
    thread.start()
    beside = 0
    while thread.is_alive() and beside < 1000:
        beside += 1
        thread.join(1e-4)
    assert beside > 10
    thread.join()
    linked = kernels.linked(one_more, inner=kernels.kernel(inner))
    assert linked.targetoptions["nogil"]  # type: ignore[attr-defined]


def test_a_plain_function_needs_no_direct_call() -> None:
    """Uncompiled kernels are passed through."""
    assert kernels.specialise(math.hypot, 1.0, 1.0) is math.hypot


def test_everything_runs_uncompiled() -> None:
    """With NUMBA_DISABLE_JIT the controller is plain Python and gives the same commands."""
    code = (
        "import json, sys, types\n"
        "from math import nan\nfrom rodless_control import *\n"
        "from rodless_control.laws import pid\n"
        "assert isinstance(pid.update, types.FunctionType)\n"
        "law = Pid(PidParameters())\n"
        f"print(json.dumps([law.update(*s) for s in {SAMPLES!r}]))"
    )
    plain = json.loads(output(code, environment(NUMBA_DISABLE_JIT="1")))
    law = Pid(PidParameters())
    for sample, expected in zip(SAMPLES, plain, strict=True):
        assert list(law.update(*sample)) == pytest.approx(expected, rel=1e-12, abs=1e-15)


class Metres(NamedTuple):
    """A length."""

    value: float


class Feet(NamedTuple):
    """Another."""

    value: float


@kernels.kernel_by_type
def in_metres(factor: float, length: Metres) -> float:
    """Return ``factor`` times a length."""
    return factor * length.value


@kernels.version_for(Feet, in_metres)
def _in_metres(factor: float, length: Feet) -> float:
    return factor * in_metres(0.3048, Metres(length.value))


@kernels.kernel
def both_in_metres(one: Metres, other: Feet) -> float:
    """Return the sum of both."""
    return in_metres(1.0, one) + in_metres(1.0, other)


def test_the_type_of_an_argument_chooses_the_version() -> None:
    """Called from Python, from compiled code and from uncompiled; one version may call another."""
    assert in_metres(2.0, Metres(3.0)) == 6.0
    assert in_metres(2.0, Feet(10.0)) == 2.0 * 3.048
    assert both_in_metres(Metres(1.0), Feet(10.0)) == 1.0 + 3.048
    plain = both_in_metres.py_func  # type: ignore[attr-defined]
    assert plain(Metres(1.0), Feet(10.0)) == 1.0 + 3.048
