"""The control laws, one per module, by the names that ``controller.law`` takes."""

import importlib
from collections.abc import Mapping

from rodless_base.parameters import ParameterError, ParameterSet
from rodless_control.controller import Law
from rodless_control.parameters import LawParameters

LAWS = {
    "pid": "rodless_control.laws.pid:Pid",
}


def law_class(name: str) -> type[Law]:
    """Return the law that ``controller.law`` names: one of ``LAWS``, or ``package.module:Class``.

    Raises ParameterError in one line that names what is missing.
    """
    path = LAWS.get(name, name)
    module_name, colon, class_name = path.partition(":")
    if not (module_name and colon and class_name):
        raise _refused(name, f"must be {', '.join(LAWS)} or package.module:Class")
    try:
        module = importlib.import_module(module_name)
    except ModuleNotFoundError as error:
        raise _refused(
            name, f"{error}; put its folder on PYTHONPATH or install the package"
        ) from error
    except Exception as error:
        raise _refused(
            name, f"importing {module_name} failed: {type(error).__name__}: {error}"
        ) from error
    law = getattr(module, class_name, None)
    if law is None:
        raise _refused(name, f"{module_name} ({module.__file__}) has no {class_name}")
    if not (isinstance(law, type) and issubclass(law, Law)):
        raise _refused(name, f"{class_name} is not a subclass of rodless_control.Law")
    return law


def make_law(law: type[Law], parameters: ParameterSet) -> Law:
    """Return a law with ``parameters``; raises ParameterError where the law cannot be made."""
    try:
        return law(parameters)
    except ParameterError:
        raise
    except Exception as error:
        raise _refused(
            f"{law.__module__}:{law.__qualname__}",
            f"{law.__name__}(parameters) failed: {type(error).__name__}: {error}",
        ) from error


def law_with(parameters: LawParameters) -> Law:
    """Return the law that a set of parameters belongs to, with these; raises ParameterError."""
    return make_law(law_class(parameters.LAW_NAME), parameters)


def without_other_laws(
    values: Mapping[str, object], parameters: type[ParameterSet]
) -> dict[str, object]:
    """Leave out what other laws of this package are given: what ``parameters`` do not declare.

    A preset tunes the laws of this package, whichever is chosen.
    """
    others = {name for law in LAWS for name in law_class(law).PARAMETERS}
    others -= parameters.DECLARATIONS.keys()
    return {name: value for name, value in values.items() if name not in others}


def _refused(name: str, reason: str) -> ParameterError:
    first, *_ = reason.splitlines()
    return ParameterError(f"controller.law: {name!r} refused: {first}")
