"""Compile plain Python functions with numba, and keep the result between processes.

Every kernel of this project stays an ordinary function: ``function.py_func`` is the
uncompiled original, and ``NUMBA_DISABLE_JIT=1`` runs all of them uncompiled.
"""

import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar, cast

import numba
from numba.core.dispatcher import Dispatcher

Kernel = TypeVar("Kernel", bound=Callable[..., object])


def _source_digest() -> str:
    # numba looks only at the file of the outermost function when it decides whether a cached
    # kernel is fresh; a change in a function it calls would go unnoticed.
    digest = hashlib.sha256()
    for path in sorted(Path(__file__).parents[1].glob("rodless_*/**/*.py")):
        source = path.read_bytes()
        if b"rodless_base.kernels" in source or path == Path(__file__):
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
