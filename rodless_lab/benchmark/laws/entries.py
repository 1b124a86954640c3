# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Which laws compete, and with which parameters."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from rodless_base.parameter_file import preset_directory, read_parameter_file
from rodless_base.parameters import ParameterError
from rodless_control import ControllerParameters
from rodless_control.controller import Law
from rodless_control.laws import LAWS, make_law

# Of a law whose gains are not those of ``calibrated``, the file that has them.
FILES = {name: f"laws/{name}.yaml" for name in ("cascade", "mode_switching")}


@dataclass(frozen=True)
class Entry:
    """A law with its parameters, under the name that tables show."""

    name: str
    law: Law


def of_package() -> list[Entry]:
    """Return the laws of the package: as ``calibrated`` or a file of their own tunes them."""
    return [tuned(name) for name in LAWS]


def tuned(name: str) -> Entry:
    """Return a law as ``calibrated`` tunes it, or of the package a file of its own."""
    return entry(name, preset_directory() / FILES[name] if name in FILES else None)


def entry(name: str, file: Path | None = None) -> Entry:
    """Return one law: of this package by name, or ``package.module:Class``.

    Its parameters come from ``file``, by default from the preset ``calibrated``. Raises
    ParameterError for a law or file that cannot be, and for a file of another law or of a plant.
    """
    kind = ControllerParameters.for_law(name)
    values = kind.preset("calibrated") if file is None else kind.from_file(file)
    if file is not None:
        _check_file_of(name, file, kind)
    return Entry(name, make_law(values.LAW_CLASS, values.of_law()))


def _check_file_of(name: str, file: Path, kind: type[ControllerParameters]) -> None:
    """Raise ParameterError where nothing in ``file`` is for this law, which would run untuned."""
    given = read_parameter_file(file, kind.NODE, kind.foreign)
    if not given:
        raise ParameterError(f"{file}: refused, it has no parameters of a controller")
    own = kind.LAW_CLASS.PARAMETERS.keys()
    if own and not own & given and kind.own(given) != given:
        raise ParameterError(
            f"{file}: refused, it tunes other laws and has none of the parameters of {name}; "
            f"without =FILE {name} has those of its preset"
        )


def files_of_users(texts: Sequence[str]) -> list[Path]:
    """Return the files that ``LAW=FILE`` name."""
    return [Path(file) for file in (text.partition("=")[2] for text in texts) if file]


def users(texts: Sequence[str]) -> list[Entry]:
    """Return the laws that ``LAW`` or ``LAW=FILE`` name, each once; raises as :func:`entry`."""
    found = []
    for text in dict.fromkeys(texts):
        name, equals, file = text.partition("=")
        if equals and not file:
            raise ParameterError(f"{text}: refused, no file after =; leave = out for tuned gains")
        found.append(Entry(text, (entry(name, Path(file)) if file else tuned(name)).law))
    return found
