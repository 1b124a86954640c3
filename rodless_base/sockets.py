"""Sockets: lists of modules of one kind, to which a new module is added by its name."""

from collections.abc import Sequence
from importlib import import_module
from types import ModuleType


def modules(package: str, names: Sequence[str]) -> tuple[ModuleType, ...]:
    """Return the modules ``names`` of ``package``, in this order."""
    return tuple(import_module(f"{package}.{name}") for name in names)
