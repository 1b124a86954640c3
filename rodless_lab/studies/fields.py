# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The fields of a study's file: each of its type, and none that is unknown."""

import difflib
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rodless_base.one_line import in_one_line, shown
from rodless_base.yaml_file import read_yaml
from rodless_lab.studies.errors import StudyError


@dataclass
class Fields:
    """A mapping of a file, whose fields are taken one by one."""

    where: str  # the file, and the key down to here
    values: dict[str, Any]
    _taken: set[str] = field(default_factory=set)

    @classmethod
    def of_file(cls, path: Path, names: Sequence[str]) -> "Fields":
        """Read a YAML file whose fields are among ``names``; raises StudyError.

        One that is misspelt is named first, before what its absence leads to.
        """
        try:
            document = read_yaml(path, "a study")
        except OSError as error:
            raise StudyError(f"{path}: cannot be read: {error.strerror}") from error
        except ValueError as error:
            raise StudyError(f"{path}: {error}") from error
        fields = cls.of(str(path), document)
        fields._refuse_others(names)
        return fields

    @classmethod
    def of(cls, where: str, value: object) -> "Fields":
        """Take a mapping of names; raises StudyError for what is none."""
        if value is None:
            raise StudyError(f"{where}: is empty, must be names and values")
        if not isinstance(value, dict) or not all(isinstance(name, str) for name in value):
            raise StudyError(f"{where}: {shown(value)} refused, must be names and values")
        return cls(where, value)

    def error(self, name: str, what: str) -> StudyError:
        """Return the error that ``what`` is wrong with a field."""
        return StudyError(f"{self.where}: {in_one_line(name)}: {what}")

    def below(self, name: str) -> "Fields":
        """Return the mapping at a field, empty where it is left out."""
        self._taken.add(name)
        value = self.values.get(name)
        return Fields.of(f"{self.where}: {in_one_line(name)}", {} if value is None else value)

    def text(self, name: str, default: str) -> str:
        """Return a text."""
        return str(self._typed(name, default, str, "a text"))

    def number(
        self, name: str, default: float, low: float = -math.inf, high: float = math.inf
    ) -> float:
        """Return a number from ``low`` to ``high``."""
        value = self._typed(name, default, (int, float), "a number")
        try:
            number = float(value)
        except OverflowError as error:
            raise self.error(name, f"{shown(value)} refused, must be a number") from error
        if not math.isfinite(number):
            raise self.error(name, f"{number} refused, must be a finite number")
        if not low <= number <= high:
            raise self.error(name, f"{number:g} refused, must be from {low:g} to {high:g}")
        return number

    def whole(self, name: str, default: int, low: float = -math.inf, high: float = math.inf) -> int:
        """Return a whole number from ``low`` to ``high``."""
        number = int(self._typed(name, default, int, "a whole number"))
        if not low <= number <= high:
            raise self.error(name, f"{shown(number)} refused, must be from {low} to {high}")
        return number

    def flag(self, name: str) -> bool:
        """Return true or false, false where it is left out."""
        self._taken.add(name)
        value = self.values.get(name, False)
        if not isinstance(value, bool):
            raise self.error(name, f"{shown(value)} refused, must be true or false")
        return value

    def list_of(self, name: str) -> list[object]:
        """Return a list, empty where it is left out."""
        return list(self._typed(name, [], list, "a list"))

    def _typed(self, name: str, default: object, kind: Any, wanted: str) -> Any:
        self._taken.add(name)
        value = self.values.get(name, default)
        if isinstance(value, bool) or not isinstance(value, kind):
            raise self.error(name, f"{shown(value)} refused, must be {wanted}")
        return value

    def end(self) -> None:
        """Raise StudyError for a field that nobody has taken."""
        self._refuse_others(sorted(self._taken))

    def _refuse_others(self, names: Sequence[str]) -> None:
        for name in self.values:
            if name not in names:
                near = difflib.get_close_matches(name, names, n=1)
                hint = f"; did you mean {near[0]}?" if near else ""
                raise self.error(name, f"no such field{hint}, there are {', '.join(names)}")
