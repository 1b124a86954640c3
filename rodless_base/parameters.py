# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What a parameter is, and a checked, immutable set of them."""

import difflib
import math
from collections.abc import Callable, Collection, Iterator, Mapping
from collections.abc import Set as AnySet
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, TypeVar

from rodless_base.file_path import file_path
from rodless_base.one_line import OneLineError, in_one_line, shown
from rodless_base.owners import owner
from rodless_base.parameter_file import preset_file, read_parameter_file
from rodless_base.real_number import is_number

Value = bool | int | float | str | tuple[float, ...]


class ParameterError(OneLineError):
    """A value, name or combination of values that the rig cannot have; the text names it.

    Examples
    --------
    >>> from rodless_sim import ParameterError, RigParameters
    >>> try:
    ...     RigParameters({"supply.presure": 6e5})
    ... except ParameterError as error:
    ...     print(error)
    supply.presure: no such parameter; did you mean supply.pressure?
    """


class ParameterFileError(ParameterError, OSError):
    """A parameter file that cannot be opened or read; the text names it and says why."""


@contextmanager
def errors_of_file(path: str | Path) -> Iterator[None]:
    """Turn what reading the parameter file ``path`` raises into errors that name it.

    OSError becomes :class:`ParameterFileError`, ValueError :class:`ParameterError`. TypeError for
    what is no path.
    """
    file_path(path, ParameterError)
    try:
        yield
    except OSError as error:
        raise ParameterFileError(f"{path}: cannot be read: {error.strerror}") from error
    except ValueError as error:
        raise ParameterError(f"{path}: {error}") from error


# The whole numbers that a ROS parameter can hold.
SMALLEST_INTEGER, LARGEST_INTEGER = -(2**63), 2**63 - 1

# What has a length and numbers in it, and is no list of numbers.
_NO_LISTS = (str, bytes, bytearray, memoryview, Mapping, AnySet)


@dataclass(frozen=True)
class Parameter:
    """The one declaration of a parameter."""

    name: str
    default: Value  # fixes the type: bool, int, float, str or a tuple of floats of that length
    unit: str
    meaning: str
    source: str
    minimum: float = -math.inf  # inclusive, in ``unit``; bounds every number of a tuple too
    maximum: float = math.inf
    choices: tuple[str, ...] = ()  # what a text may be
    fixed: bool = False  # cannot change while a node runs
    in_runs: bool = True  # False for what only nodes or the valve stand read
    # Puts numbers that are in a former unit, as older files have them, into ``unit``.
    from_former: Callable[[tuple[float, ...]], tuple[float, ...]] | None = None

    def check(self, value: object) -> Value:
        """Return ``value`` in this parameter's type, or raise :class:`ParameterError`."""
        if isinstance(self.default, bool):
            return self._checked_bool(value)
        if isinstance(self.default, str):
            return self._checked_text(value)
        if isinstance(self.default, tuple):
            numbers = self._checked_numbers(value, len(self.default))
            return self.from_former(numbers) if self.from_former else numbers
        if isinstance(self.default, int):
            return self._checked_integer(value)
        return self._checked_number(value)

    def _refuse(self, value: object, wanted: str) -> ParameterError:
        unit = f" ({self.unit})" if self.unit else ""
        return ParameterError(f"{self.name}: {shown(value)} refused, must be {wanted}{unit}")

    def _checked_bool(self, value: object) -> bool:
        if not isinstance(value, bool):
            raise self._refuse(value, "true or false")
        return value

    def _checked_text(self, value: object) -> str:
        if not isinstance(value, str) or (self.choices and value not in self.choices):
            wanted = "one of " + ", ".join(self.choices) if self.choices else "a text"
            raise self._refuse(value, wanted)
        return value

    def _checked_integer(self, value: object) -> int:
        self._checked_number(value)
        # A float has not the digits of every whole number.
        whole: int = int(value)  # type: ignore[call-overload]
        if value != whole:
            raise self._refuse(value, "a whole number")
        if not SMALLEST_INTEGER <= whole <= LARGEST_INTEGER:
            raise self._refuse(value, self.limits)
        return whole

    @property
    def limits(self) -> str:
        """What a number, or each of several, must be: "from … to …"."""
        if not isinstance(self.default, int):
            return f"from {_exact(self.minimum)} to {_exact(self.maximum)}"
        low = max(self.minimum, SMALLEST_INTEGER)
        high = min(self.maximum, LARGEST_INTEGER)
        return f"from {int(low)} to {int(high)}"

    def _checked_number(self, value: object) -> float:
        # numpy's numbers are Real too.
        if not is_number(value):
            raise self._refuse(value, "a number")
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number) or not self.minimum <= number <= self.maximum:
            raise self._refuse(value, self.limits)
        return number

    def _checked_numbers(self, value: object, length: int) -> tuple[float, ...]:
        try:
            # An array without dimensions has __len__ and no length.
            fits = not isinstance(value, _NO_LISTS) and len(value) == length  # type: ignore[arg-type]
        except TypeError:
            fits = False
        if not fits:
            raise self._refuse(value, f"{length} numbers")
        return tuple(self._checked_number(item) for item in value)  # type: ignore[attr-defined]


Set = TypeVar("Set", bound="ParameterSet")


@dataclass(frozen=True)
class _Origin:
    """The call that a set began with, and what it gave."""

    call: str
    values: Mapping[str, Value]


class ParameterSet(Mapping[str, Value]):
    """Values for every parameter a class declares; immutable, always valid as a whole.

    Subclasses give ``DECLARATIONS`` (the parameters), ``NODE`` (whose section of a parameter
    file is read) and ``REPLACED`` (what replaces each parameter there was once), and may override
    :meth:`check_together`.
    """

    DECLARATIONS: ClassVar[dict[str, Parameter]] = {}
    REPLACED: ClassVar[dict[str, str]] = {}
    NODE: ClassVar[str] = ""

    # The expression that a repr has for a class that was made by a call.
    NAMED_BY: ClassVar[str] = ""

    def __init__(self, values: Mapping[str, object] | None = None) -> None:
        """Take the defaults with ``values`` on top; raises :class:`ParameterError`."""
        given = self._named({} if values is None else values)
        self._take(given, {n: d.check(d.default) for n, d in self.DECLARATIONS.items()})

    @classmethod
    def _named(cls, values: object) -> dict[str, object]:
        try:
            # Empty, a text would pass for no values.
            if not isinstance(values, str | bytes | bytearray):
                return dict(values)  # type: ignore[call-overload, no-any-return]
            cause = None
        except (TypeError, ValueError) as error:
            cause = error
        raise TypeError(
            f"{cls.__name__}: {shown(values)} refused, must be values by name: "
            '{"name": value, ...}'
        ) from cause

    def _take(self, named: Mapping[str, object], before: Mapping[str, Value]) -> None:
        """Take ``named`` values on top of good ones."""
        unknown = [name for name in named if name not in self.DECLARATIONS]
        if unknown:
            raise ParameterError(self.unknown(unknown[0]))
        self._values: dict[str, Value] = {
            name: declared.check(named[name]) if name in named else before[name]
            for name, declared in self.DECLARATIONS.items()
        }
        changed = [name for name in named if self._values[name] != before[name]]
        self._values.update(self.derived(named, changed))
        self.check_together()
        self._origin: _Origin | None = None

    def derived(
        self,
        named: Collection[str],  # noqa: ARG002
        changed: Collection[str],  # noqa: ARG002
    ) -> Mapping[str, Value]:
        """Return what follows for others than ``named`` from those of them that ``changed``.

        Nothing here. A value that is given again as it was changes nothing.
        """
        return {}

    @classmethod
    def preset(cls: type[Set], name: str) -> Set:
        """Read a preset that ships with the package: ``paper`` or ``calibrated``.

        Raises
        ------
        ParameterError
            For a name that is no preset; the text lists those there are.

        Examples
        --------
        >>> from rodless_sim import RigParameters
        >>> RigParameters.preset("calibrated")["friction.form"]
        'saturating'
        """
        try:
            found = cls.from_file(preset_file(name))
        except FileNotFoundError as error:
            raise ParameterError(str(error)) from error
        return found._come_from(f"preset({name!r})")

    @classmethod
    def from_file(cls: type[Set], path: str | Path) -> Set:
        """Read this node's section of a ROS parameter file (YAML); what it leaves out is default.

        Raises
        ------
        ParameterError
            For a file that is none, has nothing for plant or controller, or sections for this node
            of different rigs, and for names and values as for a set; the text begins with the path.
        ParameterFileError
            Where the file cannot be read; it is a ParameterError and an OSError.

        Examples
        --------
        >>> from tempfile import TemporaryDirectory
        >>> from rodless_sim import RigParameters
        >>> text = "/rig/plant: {ros__parameters: {supply.pressure: 0.6e6}}"
        >>> with TemporaryDirectory() as folder:
        ...     path = Path(folder) / "rig.yaml"
        ...     _ = path.write_text(text)
        ...     RigParameters.from_file(path)["supply.pressure"]
        600000.0
        """
        with errors_of_file(path):
            found = cls(cls.own(read_parameter_file(path, cls.NODE, cls.foreign)))
        return found._come_from(f"from_file({str(path)!r})")

    @classmethod
    def own(cls, values: Mapping[str, object]) -> Mapping[str, object]:
        """Return what this set takes of the values that a file gives to its node: all of them."""
        return values

    @classmethod
    def foreign(cls, name: str) -> bool:
        """Whether ``name`` is another node's parameter, to be left out where a file is for all."""
        return name not in cls.DECLARATIONS and owner(name) not in (None, cls.NODE)

    def with_values(self: Set, changes: Mapping[str, object]) -> Set:
        """Return a copy with all of ``changes`` made, checked as a whole; this set stays as it is.

        Parameters
        ----------
        changes
            New values by name, in the parameters' units.

        Raises
        ------
        ParameterError
            For a name, a value or a combination of values that cannot be; the text names it.

        Examples
        --------
        >>> from rodless_sim import RigParameters
        >>> RigParameters().with_values({"supply.pressure": 0.6e6})
        RigParameters({'supply.pressure': 600000.0})
        """
        named = self._named(changes)
        changed = object.__new__(type(self))
        changed._take(named, self._values)
        changed._origin = self._origin
        return changed

    def differences(self, before: Mapping[str, Value]) -> dict[str, Value]:
        """Return the values that are not those of ``before``, by name."""
        return {name: value for name, value in self._values.items() if value != before[name]}

    def _come_from(self: Set, call: str) -> Set:
        self._origin = _Origin(call, dict(self._values))
        return self

    def check_together(self) -> None:
        """Raise :class:`ParameterError` where single good values contradict each other."""

    def number(self, name: str) -> float:
        """Return a real-valued parameter as a float, in its unit; true is 1.0.

        Raises
        ------
        KeyError
            For a name that is no parameter.
        TypeError
            For a parameter that is a text or has several numbers.

        Examples
        --------
        >>> from rodless_sim import RigParameters
        >>> RigParameters().number("cylinder.moving_mass") > 0.0
        True
        """
        value = self[name]
        if isinstance(value, float):  # most are; a run asks for a hundred
            return value
        if isinstance(value, str | tuple):
            raise TypeError(f"{name} is not a number")
        return float(value)

    def text(self, name: str) -> str:
        """Return a text parameter."""
        return str(self[name])

    def choice(self, name: str) -> int:
        """Return the place of a text parameter's value among its declared ``choices``."""
        return self.DECLARATIONS[name].choices.index(self.text(name))

    def numbers(self, name: str) -> tuple[float, ...]:
        """Return a tuple-valued parameter."""
        value = self[name]
        if not isinstance(value, tuple):
            raise TypeError(f"{name} is not a tuple")
        return value

    def __getitem__(self, name: str) -> Value:
        try:
            return self._values[name]
        except (KeyError, TypeError):  # what cannot be a key of a dict
            raise KeyError(self.unknown(name)) from None

    def __contains__(self, name: object) -> bool:
        return name in self._values

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __hash__(self) -> int:
        return hash(tuple(self._values.items()))

    def __repr__(self) -> str:
        """Show where the values come from, and what differs from there."""
        kind, origin = self.NAMED_BY or type(self).__name__, self._origin
        before = origin.values if origin else {n: p.default for n, p in self.DECLARATIONS.items()}
        changed = self.differences(before)
        text = repr(changed) if changed else ""
        if origin is None:
            return f"{kind}({text})"
        return f"{kind}.{origin.call}" + (f".with_values({text})" if changed else "")

    @classmethod
    def unknown(cls, name: object) -> str:
        """Say that ``name`` is no parameter, and which one may have been meant."""
        if not isinstance(name, str):
            return f"{shown(name)}: no such parameter; names are texts"
        line = in_one_line(name) if name == name.strip() else shown(name)
        if name in cls.REPLACED:
            return f"{name}: no longer a parameter; {cls.REPLACED[name]}"
        if cls.foreign(name):
            return f"{line}: no such parameter of the {cls.NODE}, it is the {owner(name)}'s"
        near = difflib.get_close_matches(name, cls.DECLARATIONS, n=1)
        hint = f"; did you mean {near[0]}?" if near else ""
        return f"{line}: no such parameter{hint}"


def _exact(limit: float) -> str:
    """Return ``limit`` in six digits, or in all where six would move it."""
    short = f"{limit:g}"
    return short if float(short) == limit else repr(limit)


def declare(*parameters: Parameter) -> dict[str, Parameter]:
    """Index declarations by name; raises ValueError for a name declared twice."""
    declared: dict[str, Parameter] = {}
    for parameter in parameters:
        if parameter.name in declared:
            raise ValueError(f"{parameter.name}: declared twice")
        declared[parameter.name] = parameter
    return declared


def collect(*groups: Mapping[str, Parameter]) -> dict[str, Parameter]:
    """Join several declarations in their order; raises as :func:`declare`."""
    return declare(*(parameter for group in groups for parameter in group.values()))
