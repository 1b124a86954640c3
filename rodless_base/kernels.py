"""Compile plain Python functions with numba, and keep the result between processes.

Every kernel of this project stays an ordinary function: ``function.py_func`` is the
uncompiled original, and ``NUMBA_DISABLE_JIT=1`` runs all of them uncompiled.
"""

import hashlib
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.core.dispatcher import Dispatcher

Kernel = TypeVar("Kernel", bound=Callable[..., object])
Result = TypeVar("Result")

# Kernels take the values in this file for constants, and import nothing else of the kind.
_CONSTANTS = Path(__file__).with_name("constants.py")


def _source_digest() -> str:
    # numba looks only at the file of the outermost function when it decides whether a cached
    # kernel is fresh; a change in a function it calls would go unnoticed.
    digest = hashlib.sha256()
    for path in sorted(Path(__file__).parents[1].glob("rodless_*/**/*.py")):
        source = path.read_bytes()
        if b"rodless_base.kernels" in source or path in (Path(__file__), _CONSTANTS):
            digest.update(source)
    return digest.hexdigest()[:16]


def _cache_directory() -> str:
    home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    root = os.environ.get("NUMBA_CACHE_DIR") or Path(home) / "rodless_sim"
    return str(Path(root) / _source_digest())


_CACHE_DIRECTORY = _cache_directory()


def kernel(function: Kernel) -> Kernel:
    """Compile ``function`` on first call; later processes load it from the user's cache."""
    others = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = _CACHE_DIRECTORY
    try:
        return cast(Kernel, numba.njit(cache=True, error_model="numpy")(function))
    finally:
        numba.config.CACHE_DIR = others


def specialise(function: Kernel, *example: object) -> Kernel:
    """Return ``function`` for arguments of the types of ``example`` and no others.

    Saves the look-up by type, a third of the cost of a call that takes many constants.
    """
    if not isinstance(function, Dispatcher):
        return function
    signature = tuple(numba.typeof(value) for value in example)
    function.compile(signature)
    return cast(Kernel, function.get_overload(signature))


def dispatch(functions: Sequence[Callable[..., Result]]) -> Callable[..., Result]:
    """Return one kernel for several of which a code chooses one.

    ``kernel(code, constants, *arguments)`` is ``functions[code](constants[code], *arguments)``.
    ``constants`` is a tuple with an entry for each function, each of a type of its own; the code is
    not checked. Compiled, a chain of comparisons; kernels that call it are cached as usual.
    """
    first, *others = functions
    if not others:

        def last(code: int, constants: tuple[Any, ...], *arguments: Any) -> Result:  # noqa: ARG001
            return first(constants[0], *arguments)

        return _joined(last, "dispatch", functions)
    following = dispatch(others)

    def choose(code: int, constants: tuple[Any, ...], *arguments: Any) -> Result:
        if code == 0:
            return first(constants[0], *arguments)
        return following(code - 1, constants[1:], *arguments)

    return _joined(choose, "dispatch", functions)


def total(functions: Sequence[Callable[..., float]]) -> Callable[..., float]:
    """Return one kernel for the sum of several.

    ``kernel(constants, *arguments)`` is the sum of ``functions[k](constants[k], *arguments)`` over
    all k, ``constants`` as :func:`dispatch` takes them.
    """
    *others, last = functions
    if not others:

        def only(constants: tuple[Any, ...], *arguments: Any) -> float:
            return last(constants[0], *arguments)

        return _joined(only, "total", functions)
    before = total(others)

    def add(constants: tuple[Any, ...], *arguments: Any) -> float:
        return before(constants[:-1], *arguments) + last(constants[-1], *arguments)

    return _joined(add, "total", functions)


def _joined(function: Kernel, what: str, functions: Sequence[Callable[..., object]]) -> Kernel:
    # A name of its own, for error messages and for the linker, which tells compiled functions apart
    # by name and types.
    names = ", ".join(f"{member.__module__}.{member.__qualname__}" for member in functions)
    function.__qualname__ = f"{what}({names})"
    return cast(Kernel, numba.njit(error_model="numpy")(function))
