# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Compile plain Python functions with numba, and keep the result between processes.

Every kernel of this project stays an ordinary function: ``function.py_func`` is the
uncompiled original, and ``NUMBA_DISABLE_JIT=1`` runs all of them uncompiled.
"""

import hashlib
import operator
import os
from collections.abc import Callable, Iterable, Sequence
from functools import wraps
from pathlib import Path
from types import FunctionType
from typing import Any, TypeVar, cast

import numba
from numba.core.dispatcher import Dispatcher
from numba.core.errors import NumbaError
from numba.core.registry import CPUDispatcher
from numba.extending import overload

import rodless_base.boxing  # noqa: F401  before anything is compiled
from rodless_base.kernel_cache import NOT_KEPT, KernelCache, complain, private_folder
from rodless_base.one_line import in_one_line

Kernel = TypeVar("Kernel", bound=Callable[..., object])
Result = TypeVar("Result")

_PACKAGES = Path(__file__).parents[1]

# Kernels use constants and index named tuples that any file of these may define.
_WHOLE = ("rodless_base", "rodless_sim", "rodless_control")


def _kernel_sources() -> dict[Path, bytes]:
    """Return the sources that a kernel of this project can depend on."""
    sources = {path: path.read_bytes() for path in sorted(_PACKAGES.glob("rodless_*/**/*.py"))}
    return {
        path: source
        for path, source in sources.items()
        if path.relative_to(_PACKAGES).parts[0] in _WHOLE or b"rodless_base.kernels" in source
    }


_KERNEL_SOURCES = _kernel_sources()


def source_digest() -> str:
    """Return a digest of all sources that a kernel can depend on: who shares it shares the bits."""
    # numba looks only at the file of the outermost function when it decides whether a cached
    # kernel is fresh; a change in a function it calls would go unnoticed.
    digest = hashlib.sha256()
    for source in _KERNEL_SOURCES.values():
        digest.update(source)
    return digest.hexdigest()[:16]


def _is_in_digest(function: Callable[..., object]) -> bool:
    """Whether a change of the function's source gives another cache."""
    code = getattr(function, "__code__", None)
    return code is not None and Path(code.co_filename) in _KERNEL_SOURCES


def _cache_folder() -> Path | None:
    """Return the folder for compiled code of this version, None where there can be none."""
    given, caches = (os.environ.get(name) for name in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME"))
    try:
        root = Path(given or Path(caches or Path.home() / ".cache") / "rodless_sim")
    except RuntimeError as error:  # a user without a home
        complain(f"{NOT_KEPT}: {error}")
        return None
    return private_folder(root / source_digest())


_CACHE_FOLDER = _cache_folder()


def kernel(function: Kernel) -> Kernel:
    """Compile ``function`` on first call; later processes load it from the user's cache.

    Compiled code that calls it gets a copy of its body, so that a small function costs no call. A
    function from outside this project is compiled in each process, because its sources are not in
    the cache's digest.
    """
    return _compiled(function, keep=_is_in_digest(function))


def outlined_kernel(function: Kernel) -> Kernel:
    """:func:`kernel` for what runs long, and for what is rare inside something quick.

    It stays a function of its own, and a call from Python releases the GIL. Compiled code sets up
    all the variables of a function whenever it is called; what is rare would cost in every call.
    """
    return _compiled(function, keep=_is_in_digest(function), outlined=True)


class _ByType:
    """The versions of one kernel, of which the types of its arguments choose."""

    def __init__(self, function: Callable[..., object]) -> None:
        self._others: dict[type, Callable[..., object]] = {}
        self._first = kernel(function)

    def add(self, kind: type, function: Callable[..., object]) -> None:
        self._others[kind] = function

    def chosen(self, kinds: Iterable[type | None]) -> Callable[..., object]:
        return next((self._others[kind] for kind in kinds if kind in self._others), self._first)

    def compiled(self, *types: Any) -> Callable[..., object]:
        """Return the plain function that numba compiles for arguments of its ``types``."""
        found = self.chosen(getattr(one, "instance_class", None) for one in types)
        return cast(Callable[..., object], getattr(found, "py_func", found))


_BY_TYPE: dict[Callable[..., object], _ByType] = {}


def kernel_by_type(function: Callable[..., Result]) -> Callable[..., Result]:
    """:func:`kernel` for every type but those that have a version of their own.

    What runs is known when its caller is compiled, so that a choice costs nothing.
    """
    versions = _ByType(function)

    @wraps(function)
    def choose(*arguments: Any) -> Result:
        return cast(Result, versions.chosen(map(type, arguments))(*arguments))

    overload(choose, {"error_model": "numpy", "forceinline": True}, strict=False)(versions.compiled)
    _BY_TYPE[choose] = versions
    return choose


def version_for(
    kinds: type | tuple[type, ...], function: Callable[..., object]
) -> Callable[[Kernel], Kernel]:
    """Return a decorator for the version of a :func:`kernel_by_type` for one or more named tuples.

    It takes the same arguments, and runs wherever one of them is one of ``kinds``.
    """

    def add(version: Kernel) -> Kernel:
        compiled = kernel(version)
        for kind in kinds if isinstance(kinds, tuple) else (kinds,):
            _BY_TYPE[function].add(kind, compiled)
        return compiled

    return add


def is_kernel(function: object) -> bool:
    """Whether compiled code can call ``function``."""
    return isinstance(function, Dispatcher) or bool(numba.config.DISABLE_JIT)


def linked(function: Kernel, **kernels: Callable[..., object]) -> Kernel:
    """Compile a copy of ``function`` that calls ``kernels`` by the names they are given as.

    It is an :func:`outlined_kernel`.

    The copy is kept between processes where all of ``kernels`` are. numba keeps no function that
    takes others as arguments.
    """
    plain = [getattr(item, "py_func", item) for item in kernels.values()]
    # The cache tells copies apart by their names.
    name = "_".join(
        [function.__name__, *(f"{item.__module__}_{item.__qualname__}" for item in plain)]
    )
    copy = unlinked(function, **kernels)
    copy.__qualname__ = name
    keep = all(map(_is_in_digest, [function, *plain]))
    return _compiled(copy, keep, outlined=True)


def unlinked(function: Kernel, **functions: Callable[..., object]) -> Kernel:
    """Return the copy that :func:`linked` compiles, as plain Python."""
    scope = {**function.__globals__, **functions}
    return cast(Kernel, FunctionType(function.__code__, scope, function.__name__))


class _Inlined(CPUDispatcher):  # type: ignore[misc]
    """What is compiled twice at most: for compiled code, and once more where Python calls it.

    What takes a function's arguments from Python is much larger than a small function with many
    constants: a third of all compiling, for what is hardly ever called from there.
    """

    def __init__(self, function: Callable[..., object], options: dict[str, object]) -> None:
        super().__init__(function, targetoptions=options)
        inner = {**options, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
        self.inner = CPUDispatcher(function, targetoptions=inner)

    def get_call_template(self, args: object, kws: object) -> object:
        return self.inner.get_call_template(args, kws)

    def get_overload(self, sig: object) -> object:
        return self.inner.get_overload(sig)


def _compiled(function: Kernel, keep: bool, outlined: bool = False) -> Kernel:
    if not isinstance(function, FunctionType):
        raise TypeError(f"{function!r} is not a plain function: only those are compiled")
    if numba.config.DISABLE_JIT:
        return function
    options: dict[str, object] = {"nopython": True, "boundscheck": None, "error_model": "numpy"}
    if outlined:
        compiled = CPUDispatcher(function, targetoptions={**options, "nogil": True})
    else:
        compiled = _Inlined(function, {**options, "forceinline": True})
    if keep and _CACHE_FOLDER is not None:
        _keep(compiled, _CACHE_FOLDER)
        if not outlined:
            _keep(compiled.inner, _CACHE_FOLDER, "inlined")
    return cast(Kernel, compiled)


def _keep(compiled: Dispatcher, folder: Path, form: str = "") -> None:
    """Do what numba's ``cache=True`` does, with a cache that survives damage, in ``folder``."""
    others = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(folder)
    try:
        cast(Any, compiled)._cache = KernelCache(compiled.py_func, form)
    except (RuntimeError, OSError) as error:
        complain(f"compiled code is not kept, each start compiles anew: {error}")
    finally:
        numba.config.CACHE_DIR = others


def specialise(function: Kernel, *example: object) -> Kernel:
    """Return ``function`` for arguments of the types of ``example`` and no others.

    Saves the look-up by type, a third of the cost of a call that takes many constants.
    """
    if not isinstance(function, Dispatcher):
        return function
    signature = tuple(numba.typeof(value) for value in example)
    try:
        return cast(Kernel, function.compile(signature))
    except NumbaError as error:
        raise TypeError(f"does not compile: {_first_cause(error)}") from error


def is_kept(function: Kernel, *example: object) -> bool:
    """Whether :func:`specialise` would find this without compiling it."""
    if not isinstance(function, Dispatcher):
        return True
    signature = tuple(numba.typeof(value) for value in example)
    if signature in function.overloads:
        return True
    cache = cast(Any, function)._cache
    return isinstance(cache, KernelCache) and cache.holds(signature, function.targetctx)


def keeps(function: Kernel) -> bool:
    """Whether what one process compiles of ``function`` is there for others."""
    return isinstance(function, Dispatcher) and isinstance(cast(Any, function)._cache, KernelCache)


def _first_cause(error: NumbaError) -> str:
    """Return the sentence of numba's pages that says what is wrong, and where."""
    text, *_ = str(error).partition("During:")
    lines = (line for line in text.splitlines() if not line.startswith("Failed in nopython mode"))
    return in_one_line(" ".join(lines))


def same_type(first: object, second: object) -> bool:
    """Whether compiled code has one type for both."""
    return bool(numba.typeof(first) == numba.typeof(second))


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


def total(
    functions: Sequence[Callable[..., Result]],
    zero: Any = 0.0,
    plus: Callable[[Any, Any], Any] = operator.add,
) -> Callable[..., Result]:
    """Return one kernel for the sum of several.

    ``kernel(constants, *arguments)`` is the sum of ``functions[k](constants[k], *arguments)`` over
    all k, ``constants`` as :func:`dispatch` takes them; ``zero`` where there are none. ``plus`` is
    a kernel that adds two.
    """
    if not functions:

        def nothing(constants: tuple[Any, ...], *arguments: Any) -> Any:  # noqa: ARG001
            return zero

        return _joined(nothing, "total", functions)
    *others, last = functions
    if not others:

        def only(constants: tuple[Any, ...], *arguments: Any) -> Result:
            return last(constants[0], *arguments)

        return _joined(only, "total", functions)
    before = total(others, zero, plus)

    def add(constants: tuple[Any, ...], *arguments: Any) -> Any:
        return plus(before(constants[:-1], *arguments), last(constants[-1], *arguments))

    return _joined(add, "total", functions)


def _joined(function: Kernel, what: str, functions: Sequence[Callable[..., object]]) -> Kernel:
    # A name of its own, for error messages and for the linker, which tells compiled functions apart
    # by name and types.
    names = ", ".join(f"{member.__module__}.{member.__qualname__}" for member in functions)
    function.__qualname__ = f"{what}({names})"
    return cast(Kernel, numba.njit(error_model="numpy", forceinline=True)(function))
