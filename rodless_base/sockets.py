"""Sockets: lists of modules of one kind, to which a new module is added by its name."""

from collections.abc import Sequence
from importlib import import_module
from types import ModuleType

from rodless_base.kernels import is_kernel


def modules(package: str, names: Sequence[str]) -> tuple[ModuleType, ...]:
    """Return the modules ``names`` of ``package``, in this order."""
    return tuple(import_module(f"{package}.{name}") for name in names)


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
