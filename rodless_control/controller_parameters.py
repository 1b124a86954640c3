# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""All parameters of the controller node."""

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from typing import ClassVar

from rodless_base import frames
from rodless_base.one_line import in_one_line, shown
from rodless_base.parameters import Parameter, ParameterError, ParameterSet
from rodless_control.controller import Law, checked_declarations, checked_terms
from rodless_control.laws import law_class, of_other_law, without_other_laws
from rodless_control.parameters import NODE_PARAMETERS, OUTPUT, REFERENCE, LawParameters

DEFAULT_LAW = str(NODE_PARAMETERS["controller.law"].default)


def _declarations(name: str, law: type[Law]) -> dict[str, Parameter]:
    """Compose the node's set for a law; raises ParameterError where the law's names cannot be."""
    try:
        checked_terms(law)
        checked_declarations(law)
    except TypeError as error:
        raise ParameterError(f"controller.law: {shown(name)} refused: {error}") from error
    chosen = replace(NODE_PARAMETERS["controller.law"], default=name)
    return {**law.PARAMETERS, **OUTPUT, **NODE_PARAMETERS, "controller.law": chosen, **REFERENCE}


class ControllerParameters(ParameterSet):
    """The controller node's parameters, with the law ``pid``; see docs/parameters.md.

    :meth:`for_law` gives the class for another law.

    Examples
    --------
    >>> values = ControllerParameters({"reference.type": "move", "controller.kp": 500.0})
    >>> values["reference.velocity"], values["controller.law"]
    (0.05, 'pid')
    """

    LAW_CLASS: ClassVar[type[Law]] = law_class(DEFAULT_LAW)
    DECLARATIONS: ClassVar[dict[str, Parameter]] = _declarations(DEFAULT_LAW, LAW_CLASS)
    NODE: ClassVar[str] = "controller"

    @staticmethod
    @cache
    def for_law(name: str) -> "type[ControllerParameters]":
        """Return the node's set for one law.

        Parameters
        ----------
        name
            What ``controller.law`` names: a law of this package, or ``package.module:Class``.

        Raises
        ------
        ParameterError
            In one line: for a law that cannot be imported or is no ``Law``, for a parameter of the
            law that has a name of the node's, and for ``TERMS`` that cannot be topics.

        Examples
        --------
        >>> ControllerParameters.for_law("pid") is ControllerParameters
        True
        """
        if name == DEFAULT_LAW:
            return ControllerParameters
        law = law_class(name)
        content = {
            "__doc__": f"The controller node's parameters, with the law {name}.",
            "NAMED_BY": f"ControllerParameters.for_law({name!r})",
            "LAW_CLASS": law,
            "DECLARATIONS": _declarations(name, law),
        }
        return type("ControllerParameters", (ControllerParameters,), content)

    def __reduce__(self) -> tuple[object, ...]:
        """Let :mod:`pickle` find the class of a law again, which no module holds."""
        return _restored, (self.text("controller.law"), vars(self))

    def of_law(self) -> LawParameters:
        """Return what the law is given."""
        kind = self.LAW_CLASS.Parameters
        return kind({name: self[name] for name in kind.DECLARATIONS})

    @classmethod
    def own(cls, values: Mapping[str, object]) -> dict[str, object]:
        """Leave out what a file gives to other laws of this package."""
        return without_other_laws(values, cls)

    @classmethod
    def unknown(cls, name: object) -> str:
        """Say that ``name`` is no parameter, and of which other law it may be one."""
        if not isinstance(name, str) or name in cls.REPLACED or cls.foreign(name):
            return super().unknown(name)
        other = of_other_law(name, cls.DECLARATIONS)
        return f"{in_one_line(name)}: {other}" if other else super().unknown(name)

    def check_together(self) -> None:
        """Refuse another law, and what law, step or sine cannot have."""
        name, own = self.text("controller.law"), self.DECLARATIONS["controller.law"].default
        if name != own:
            raise ParameterError(
                f"controller.law: {shown(name)} refused: these are the parameters of {own!r}; "
                f"use ControllerParameters.for_law({shown(name)})"
            )
        self.of_law()
        frames.check(self)
        self._check_reference()

    def _check_reference(self) -> None:
        low, high = self.number("reference.minimum"), self.number("reference.maximum")
        if not low < high:
            raise ParameterError(
                f"reference.minimum: {low:g} m refused, must be less than "
                f"reference.maximum ({high:g} m)"
            )
        match self.text("reference.type"):
            case "step":
                for name in ("reference.start", "reference.target"):
                    self.check_travel(name, self.number(name))
            case "sine":
                centre, amplitude = (
                    self.number("reference.centre"),
                    self.number("reference.amplitude"),
                )
                for end in (centre - amplitude, centre + amplitude):
                    self.check_travel("reference.centre ± reference.amplitude", end)

    def check_travel(self, what: str, position: float) -> None:
        """Raise ParameterError for a position (m) that ``what`` may not ask for."""
        low, high = self.number("reference.minimum"), self.number("reference.maximum")
        if not math.isfinite(position):
            raise ParameterError(f"{what}: {position!r} m refused, must be a finite number")
        if not low <= position <= high:
            limit = "minimum" if position < low else "maximum"
            raise ParameterError(
                f"{what}: {position!r} m refused, must be from reference.minimum ({low:g} m) to "
                f"reference.maximum ({high:g} m); change reference.{limit} for another travel"
            )


def _restored(law: str, state: dict[str, object]) -> ControllerParameters:
    kind = ControllerParameters.for_law(law)
    found = kind.__new__(kind)
    vars(found).update(state)
    return found
