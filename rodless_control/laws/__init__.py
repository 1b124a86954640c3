# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The control laws, one per module, by the names that ``controller.law`` takes."""

import difflib
import importlib
import sys
from collections.abc import Iterable, Mapping
from operator import attrgetter

from rodless_base.one_line import described, in_one_line, shown, traced
from rodless_base.parameters import ParameterError, ParameterSet
from rodless_base.start import StoppedError
from rodless_control.controller import Law, checked_base
from rodless_control.law_calls import LawCalls
from rodless_control.parameters import LawParameters

LAWS = {
    "pid": "rodless_control.laws.pid:Pid",
    "state_feedback": "rodless_control.laws.state_feedback:StateFeedback",
    "cascade": "rodless_control.laws.cascade:Cascade",
    "mode_switching": "rodless_control.laws.mode_switching:ModeSwitching",
    "sliding_mode": "rodless_control.laws.sliding_mode:SlidingMode",
    "adrc": "rodless_control.laws.adrc:Adrc",
}


def law_class(name: str) -> type[Law]:
    """Return the law that ``controller.law`` names: one of ``LAWS``, or ``package.module:Class``.

    Raises ParameterError in one line that names what is missing.
    """
    if not isinstance(name, str):
        raise _refused(name, f"must be {', '.join(LAWS)} or package.module:Class")
    path = LAWS.get(name, name)
    module_name, colon, class_name = path.partition(":")
    if not (module_name and colon and class_name):
        raise _refused(name, f"must be {', '.join(LAWS)} or package.module:Class")
    try:
        with LawCalls.making():
            module = importlib.import_module(module_name)
    except StoppedError:
        raise
    except ModuleNotFoundError as error:
        if not f"{module_name}.".startswith(f"{error.name}."):
            raise _refused(name, f"importing {module_name} failed: {traced(error)}") from error
        raise _refused(
            name, f"{described(error)}; put its folder on PYTHONPATH or install the package"
        ) from error
    except BaseException as error:  # a module can also call sys.exit, and a node must not follow it
        if isinstance(error, KeyboardInterrupt) and module_name in sys.modules:
            raise  # Ctrl-C on the way to what is there already
        raise _refused(name, f"importing {module_name} failed: {_raised(error)}") from error
    try:
        law = attrgetter(class_name)(module)
    except Exception as error:
        where = getattr(module, "__file__", "no file")
        raise _refused(name, f"{module_name} ({where}) has no {class_name}") from error
    if not (isinstance(law, type) and issubclass(law, Law)):
        raise _refused(name, f"{class_name} is not a subclass of rodless_control.Law")
    return law


def make_law(law: type[Law], parameters: ParameterSet) -> Law:
    """Return a law with ``parameters``; raises ParameterError where the law cannot be made."""
    try:
        with LawCalls.making():
            made = checked_base(law(parameters))
    except StoppedError:
        raise
    except ParameterError as error:
        raise ParameterError(described(error)) from error
    except (Exception, SystemExit) as error:
        raise _refused(
            f"{law.__module__}:{law.__qualname__}",
            f"{law.__name__}(parameters) failed: {_raised(error)}",
        ) from error
    if law.update is Law.update:
        raise _refused(
            f"{law.__module__}:{law.__qualname__}",
            f"{law.__name__} has no update(self, measurement, reference, interval)",
        )
    return made


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


def of_other_law(name: str, declared: Iterable[str]) -> str:
    """Say what ``name`` is, or may mean, among the parameters of other laws of this package.

    Empty where it is none of them, and nearer to what is ``declared``.
    """
    own = set(declared)
    others = {
        parameter: law
        for law in reversed(LAWS)  # where two have it, the first
        for parameter in law_class(law).PARAMETERS
        if parameter not in own
    }
    if name in others:
        return f"belongs to the law {others[name]}, which controller.law chooses"
    near = difflib.get_close_matches(name, [*own, *others], n=1)
    meant = [one for one in near if one in others]
    return "".join(f"no such parameter; did you mean {one} of {others[one]}?" for one in meant)


def _raised(error: BaseException) -> str:
    return f"{type(error).__name__}: {described(error)}"


def _refused(name: object, reason: str) -> ParameterError:
    return ParameterError(f"controller.law: {shown(name)} refused: {in_one_line(reason)}")
