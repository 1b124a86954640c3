# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Sockets: lists of modules of one kind, to which a new module is added by its name."""

from collections.abc import Callable, Sequence
from importlib import import_module
from types import ModuleType
from weakref import WeakSet

from rodless_base.kernels import is_kernel
from rodless_base.one_line import shown
from rodless_base.parameters import Parameter, declare


def modules(package: str, names: Sequence[str]) -> tuple[ModuleType, ...]:
    """Return the modules ``names`` of ``package``, in this order."""
    return tuple(import_module(f"{package}.{name}") for name in names)


def chooser(name: str, found: Sequence[ModuleType], source: str) -> dict[str, Parameter]:
    """Declare the parameter ``name`` that chooses one of :func:`choices`, by default the first."""
    meaning = "; ".join(f"{module.NAME}: {module.MEANING}" for module in found)
    names = tuple(module.NAME for module in found)
    return declare(Parameter(name, names[0], "", meaning, source, choices=names))


# Of thousands of rigs the first tells: a compiled function returns one type, whatever the numbers.
_CHECKED: WeakSet[Callable[..., object]] = WeakSet()


def check_kernel(module: ModuleType, name: str, example: object, *arguments: object) -> None:
    """Raise TypeError, with the module, where its kernel ``name`` returns other types than example.

    The compiler would name neither.
    """
    kernel = getattr(module, name)
    if kernel in _CHECKED:
        return
    try:
        found = getattr(kernel, "py_func", kernel)(*arguments)
    except (ArithmeticError, ValueError):  # compiled code goes on with infinity, or NaN
        return
    if not _alike(found, example):
        raise TypeError(
            f"{module.__name__}: {name} returns {shown(found)}, but must return a "
            f"{type(example).__name__}, such as {example!r}; write 0.0 for 0"
        )
    _CHECKED.add(kernel)


def _alike(found: object, example: object) -> bool:
    """Whether both are of one type, and so are their fields."""
    if isinstance(found, tuple) and isinstance(example, tuple) and len(found) == len(example):
        return type(found) is type(example) and all(map(_alike, found, example))
    return isinstance(found, type(example))


def choices(package: str, names: Sequence[str], kernels: Sequence[str]) -> tuple[ModuleType, ...]:
    """Return :func:`modules` of which a parameter chooses one by its ``NAME``.

    Raises TypeError, with the module, for one without a ``NAME``, with that of another, or with one
    of the functions ``kernels`` missing or not compiled.
    """
    found = modules(package, names)
    taken: dict[str, str] = {}
    for module in found:
        name = getattr(module, "NAME", None)
        if not (isinstance(name, str) and name):
            raise TypeError(f"{module.__name__}: no NAME; give it one, a text to choose it by")
        if name in taken:
            raise TypeError(
                f"{module.__name__}: NAME {name!r} is that of {taken[name]}; choose another"
            )
        taken[name] = module.__name__
        for kernel in kernels:
            if not is_kernel(getattr(module, kernel, None)):
                raise TypeError(
                    f"{module.__name__} ({name}): {kernel} is missing or not compiled; decorate it "
                    "with rodless_base.kernels.kernel"
                )
    return found
