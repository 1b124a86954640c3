"""Mutation testing: put small faults into the code, one at a time, and see whether tests notice.

    python .ci/mutation.py [module …] [--sample N] [--seed N]

cosmic-ray makes the faults; `.ci/mutation.toml` says in which modules, which of the quick tests see
each, and which faults change nothing. Tests run uncompiled, as compiling a faulty kernel takes half
a minute, and each in a fork of one process that has imported the libraries, as that takes seconds.
Where a module has more faults than the sample, some are drawn. Ends with 1 where too few are found.
"""

import argparse
import ast
import compileall
import difflib
import itertools
import os
import random
import re
import resource
import shutil
import signal
import sys
import tempfile
from collections.abc import Iterator
from importlib.util import cache_from_source, find_spec
from pathlib import Path
from py_compile import PycInvalidationMode
from typing import NamedTuple

os.environ["NUMBA_DISABLE_JIT"] = "1"

# Imported for the tests' sake, once for all forks; nothing of the project's own.
import hypothesis  # noqa: F401
import numba  # noqa: F401
import pytest
import scipy.integrate
import scipy.optimize  # noqa: F401
from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.operators.operator import Operator
from cosmic_ray.plugins import get_operator, operator_names

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("rodless_base", "rodless_sim", "rodless_control", "rodless_lab", "rodless_pytest")

# What is not tried: bit operators, which floats do not have (and `|` in annotations); `is` for
# `==`, which often is the same; decorators, as uncompiled kernels are the same without; names.
LEFT_OUT = re.compile(
    r"RShift|LShift|BitOr|BitAnd|BitXor|(Eq|Lt|LtE|Gt|GtE)_Is|RemoveDecorator|NoOp"
    r"|VariableReplacer|VariableInserter"
)

# A mutant may run for ever. Its tests have this much processor time, s, or five times what they
# need, and wall time in plenty, as the machine may be busy.
LEAST_TIME = 10.0
WALL_TIME = 600


class Mutant(NamedTuple):
    """One fault."""

    code: str  # the whole module
    line: int
    change: str  # the line before and after


def mutants(source: str, seed: str) -> Iterator[Mutant]:
    """Yield every fault that cosmic-ray knows and that gives another program, in random order."""
    places = list(_places(source))
    random.Random(seed).shuffle(places)
    sound = ast.dump(ast.parse(source))
    for operator, occurrence in places:
        code = mutate_code(source, operator, occurrence)
        try:
            differs = ast.dump(ast.parse(code)) != sound
        except SyntaxError:  # `**` before a dictionary is no power
            continue
        if differs:
            yield Mutant(code, *_difference(source, code))


def _places(source: str) -> Iterator[tuple[Operator, int]]:
    """Yield each operator with each of its occurrences in ``source``."""
    nodes = list(ast_nodes(get_ast(source)))
    for name in sorted(operator_names()):
        if not LEFT_OUT.search(name):
            operator = get_operator(name)()
            count = sum(len(list(operator.mutation_positions(node))) for node in nodes)
            yield from ((operator, occurrence) for occurrence in range(count))


def _difference(before: str, after: str) -> tuple[int, str]:
    """Return the number of the first line that differs, and both versions of what does."""
    old, new = before.splitlines(), after.splitlines()
    matcher = difflib.SequenceMatcher(None, old, new, autojunk=False)
    _, start, end, low, high = next(o for o in matcher.get_opcodes() if o[0] != "equal")
    was, now = (" ".join(" ".join(part).split()) for part in (old[start:end], new[low:high]))
    return start + 1, f"{was} => {now}"


class Checkout:
    """A copy of the installed packages, in which one module at a time is faulty."""

    def __init__(self, folder: Path) -> None:
        """Copy the packages into ``folder`` and import them from there."""
        self._folder = folder
        for package in PACKAGES:
            spec = find_spec(package)
            assert spec is not None
            assert spec.origin is not None
            shutil.copytree(
                Path(spec.origin).parent,
                folder / package,
                ignore=shutil.ignore_patterns("__pycache__"),
            )
        # Once for all forks, which need not look whether it is fresh.
        compileall.compile_dir(
            folder, quiet=1, invalidation_mode=PycInvalidationMode.UNCHECKED_HASH
        )
        sys.path.insert(0, str(folder))

    def source(self, module: str) -> str:
        """Return the source of ``module``, a path."""
        return (self._folder / module).read_text(encoding="utf-8")

    def passes(
        self, module: str, code: str, tests: list[str], seconds: float, output: Path
    ) -> tuple[bool, float]:
        """Whether ``tests`` pass with ``code`` in place of ``module``, and the time (s) it took."""
        path = self._folder / module
        original = path.read_text(encoding="utf-8")
        path.write_text(code, encoding="utf-8")
        Path(cache_from_source(str(path))).unlink(missing_ok=True)
        try:
            process = os.fork()
            if process == 0:
                _run(tests, seconds, output)
            _, status, usage = os.wait4(process, 0)
        finally:
            path.write_text(original, encoding="utf-8")
        return status == 0, usage.ru_utime + usage.ru_stime


def _run(tests: list[str], seconds: float, output: Path) -> None:
    """Run tests in this process, which ends with them."""
    sys.dont_write_bytecode = True
    limit = int(seconds) + 1
    resource.setrlimit(resource.RLIMIT_CPU, (limit, limit))
    signal.alarm(WALL_TIME)
    stream = os.open(output, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    os.dup2(stream, 1)
    os.dup2(stream, 2)
    os.chdir(ROOT)
    options = ["-x", "-q", "--tb=line", "-m", "not ros and not slow"]
    plugins = [f"-pno:{name}" for name in ("cacheprovider", "xdist", "xdist.looponfail", "cov")]
    os._exit(int(pytest.main([*options, *plugins, *(f"test/{test}" for test in tests)])))


def listed(settings: dict, module: str) -> list[str]:
    """Return the tests of ``module``, those of its groups among them."""
    groups = {f"@{name}": tests for name, tests in settings["groups"].items()}
    return [test for name in settings["modules"][module] for test in groups.get(name, [name])]


def tried(checkout: Checkout, module: str, settings: dict, sample: int, seed: int) -> list[bool]:
    """Try the faults of ``module``; return for each whether it was found, and name the others."""
    source = checkout.source(module)
    tests = listed(settings, module)
    output = Path(tempfile.gettempdir()) / f"mutation-{os.getuid()}-{os.getpid()}.txt"
    sound, needed = checkout.passes(module, source, tests, 600.0, output)
    if not sound:
        sys.exit(f"{module}: its tests fail without a fault:\n{output.read_text()}")
    known = {change for change, _ in settings["equivalent"].get(module, ())}
    faults = (found for found in mutants(source, f"{seed} {module}") if found.change not in known)
    limit = max(LEAST_TIME, 5.0 * needed)
    killed = []
    for mutant in itertools.islice(faults, sample):
        passed, _ = checkout.passes(module, mutant.code, tests, limit, output)
        killed.append(not passed)
        if passed:
            print(f"  {module}:{mutant.line}: {mutant.change}", flush=True)
    output.unlink(missing_ok=True)
    of = len(list(_places(source)))
    print(
        f"{module}: {sum(killed)} of {len(killed)} found, out of {of} ({needed:.1f} s each)",
        flush=True,
    )
    return killed


def main() -> None:
    """Try all modules, or those named."""
    settings = tomllib.loads((ROOT / ".ci/mutation.toml").read_text(encoding="utf-8"))
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("modules", nargs="*", default=list(settings["modules"]))
    parser.add_argument("--sample", type=int, default=settings["sample"])
    parser.add_argument("--seed", type=int, default=settings["seed"])
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        checkout = Checkout(Path(folder))
        killed = [
            found
            for module in arguments.modules
            for found in tried(checkout, module, settings, arguments.sample, arguments.seed)
        ]
    share = sum(killed) / max(len(killed), 1)
    print(f"{sum(killed)} of {len(killed)} faults found: {share:.1%}")
    sys.exit(share < settings["least"])


if __name__ == "__main__":
    main()
