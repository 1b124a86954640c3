# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Scenarios: which parameters of a rig, faults and others, change when, in plant time."""

import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from itertools import islice, pairwise
from pathlib import Path
from typing import Any, NamedTuple

from rodless_base.constants import NANOSECONDS_PER_SECOND
from rodless_base.file_path import file_path
from rodless_base.one_line import listed, shown
from rodless_base.parameter_file import flattened, preset_directory
from rodless_base.parameters import ParameterError, ParameterFileError, Value
from rodless_base.yaml_file import read_yaml
from rodless_sim.parameters import RigParameters
from rodless_sim.single_number import single_number

# The key of an entry's time; every other is a parameter.
AT = "at"

LATEST = 1e6  # s, as time.duration
MOST_ENTRIES = 1000


class ScenarioError(ParameterError):
    """A scenario that no rig can follow; the text names scenario, entry, value and cause.

    Examples
    --------
    >>> from rodless_sim import Scenario, ScenarioError
    >>> try:
    ...     Scenario([(1.0, {"fault.valve.ofset": 0.2})], "drift")
    ... except ScenarioError as error:
    ...     print(error)
    drift: entry 1: fault.valve.ofset: no such parameter; did you mean fault.valve.offset?
    """


class ScenarioStateError(ScenarioError):
    """A rig whose state, when an entry is due, does not allow it; that of another one may."""


class ScenarioFileError(ScenarioError, ParameterFileError):
    """A scenario file that cannot be opened or read; the text names it and says why."""


class Entry(NamedTuple):
    """What changes at one time."""

    stamp: int  # ns of plant time
    changes: Mapping[str, Value]  # parameters by name

    @property
    def text(self) -> str:
        """Say when, and what becomes of which parameter."""
        changes = ", ".join(f"{name} {_shown(name, value)}" for name, value in self.changes.items())
        return f"{self.stamp / NANOSECONDS_PER_SECOND:g} s: {changes}"


class Scenario:
    """Changes of parameters at given plant times.

    An entry takes effect at the first sample at or after its time: that sample is read by the
    instruments as they are then, and the plant moves on from it with the values it gives.

    Parameters
    ----------
    entries
        Time in s and values by name, in the parameters' units; times must not fall.
    name
        What errors call the scenario.

    Raises
    ------
    ScenarioError
        For an entry that is none, a time that is none or falls, a name that is no parameter, a
        parameter that is fixed while the plant runs, and a value outside its range.

    Examples
    --------
    >>> from rodless_sim import RigParameters, Scenario, simulate
    >>> burst = Scenario([(0.3, {"fault.tube_a.burst": 1e-5})])
    >>> run = simulate(RigParameters(), [6.0] * 500, period=1e-3, scenario=burst)
    >>> f"{run.pressure_a[299] * 1e-5:.1f} bar, then {run.pressure_a[-1] * 1e-5:.1f} bar"
    '6.1 bar, then 1.0 bar'
    """

    def __init__(
        self, entries: Iterable[tuple[float, Mapping[str, object]]], name: str = "scenario"
    ) -> None:
        """Take the entries; raises ScenarioError."""
        self.name = str(name) if isinstance(name, str | Path) else shown(name)
        given = _listed(entries, self.name)
        self.entries = tuple(self._entry(*numbered) for numbered in enumerate(given, 1))
        for number, (before, after) in enumerate(pairwise(self.entries), 2):
            if after.stamp < before.stamp:
                raise self._error(
                    number,
                    f"at {after.stamp / NANOSECONDS_PER_SECOND:g} s refused: the entry before it "
                    f"is at {before.stamp / NANOSECONDS_PER_SECOND:g} s; put them in order of time",
                )

    def __repr__(self) -> str:
        """Show name and number of entries."""
        return f"<Scenario {self.name}: {len(self.entries)} entries>"

    @classmethod
    def from_file(cls, path: str | Path) -> "Scenario":
        """Read a scenario file (YAML): a list of entries of ``at`` (s) and parameters.

        Raises
        ------
        ScenarioError
            As for a scenario; the text begins with the path.
        ScenarioFileError
            Where the file cannot be read; it is a ScenarioError and an OSError.

        Examples
        --------
        >>> from rodless_sim import Scenario
        >>> from rodless_sim.scenario import shipped_scenario
        >>> print(Scenario.from_file(shipped_scenario("leak")).entries[0].text)
        1 s: fault.piston.leak 5e-09 m²
        """
        with _errors_of_file(path):
            document = read_yaml(path, "a scenario")
            if not isinstance(document, list):
                raise ValueError(
                    "not a scenario: must be a list, each entry with `at:` in s and parameters"
                )
        return cls((_split(entry) for entry in document), str(path))

    def check(self, parameters: RigParameters) -> None:
        """Raise ScenarioError where a rig of ``parameters`` would refuse an entry."""
        for _ in self.stages(parameters):
            pass

    def stages(self, parameters: RigParameters) -> Iterator[RigParameters]:
        """Yield what ``parameters`` become with each entry; raises as :meth:`check`."""
        for number, entry in enumerate(self.entries, 1):
            try:
                parameters = parameters.with_values(entry.changes)
            except ParameterError as error:
                raise self._error(number, str(error)) from error
            yield parameters

    def _entry(self, number: int, entry: object) -> Entry:
        try:
            at, changes = _pair(entry)
            if at is None:
                names = [shown(name) for name in changes] if isinstance(changes, Mapping) else []
                given = f"; it has {listed(names)}" if names else ""
                raise ValueError(f"`{AT}:`, a time in s, is missing{given}")
            time = single_number(at, AT, "seconds")
            if not 0.0 <= time <= LATEST:
                raise ValueError(f"{AT} {shown(at)} refused: must be from 0 to {LATEST:g} s")
            named = flattened(changes) if isinstance(changes, Mapping) else {}
            if not named:
                raise ValueError(f"{shown(changes)} refused: give parameters by name")
            values = {_name(name): _checked(name, value) for name, value in named.items()}
        except (TypeError, ValueError) as error:
            raise self._error(number, str(error)) from error
        return Entry(round(time * NANOSECONDS_PER_SECOND), values)

    def _error(self, number: int, what: str) -> ScenarioError:
        return ScenarioError(f"{self.name}: entry {number}: {what}")


def _listed(entries: Iterable[object], name: str) -> list[object]:
    refusal = ScenarioError(f"{name}: {shown(entries)} refused: must be a list of entries")
    if not isinstance(entries, Iterable) or isinstance(entries, str | bytes | Mapping):
        raise refusal
    try:
        found = list(islice(entries, MOST_ENTRIES + 1))
    except TypeError as error:  # of an array that is one number
        raise refusal from error
    if len(found) > MOST_ENTRIES:
        raise ScenarioError(f"{name}: more than {MOST_ENTRIES} entries refused; leave some out")
    return found


def _split(entry: object) -> Any:
    """Return time and parameters of an entry in a file; what is none stays as it is."""
    if not isinstance(entry, dict):
        return entry
    return entry.get(AT), {key: value for key, value in entry.items() if key != AT}


def _pair(entry: object) -> tuple[object, object]:
    if not isinstance(entry, tuple | list) or len(entry) != 2:
        raise ValueError(f"{shown(entry)} refused: must be a time in s, and parameters by name")
    return entry[0], entry[1]


def _name(name: object) -> str:
    declared = RigParameters.DECLARATIONS.get(name) if isinstance(name, str) else None
    if declared is None:
        raise ParameterError(RigParameters.unknown(name))
    if declared.fixed:
        raise ParameterError(
            f"{name}: cannot change while the plant runs; give it when the plant starts"
        )
    return declared.name


def _checked(name: str, value: object) -> Value:
    return RigParameters.DECLARATIONS[name].check(value)


def _shown(name: str, value: Value) -> str:
    unit = RigParameters.DECLARATIONS[name].unit
    text = f"{value:g}" if isinstance(value, float) else str(value)
    return f"{text} {unit}".rstrip()


@contextmanager
def _errors_of_file(path: str | Path) -> Iterator[None]:
    file_path(path, ScenarioError)
    try:
        yield
    except OSError as error:
        raise ScenarioFileError(f"{path}: cannot be read: {error.strerror}") from error
    except ScenarioError:
        raise
    except ValueError as error:
        raise ScenarioError(f"{path}: {error}") from error


def _shipped() -> dict[str, Path]:
    folder = preset_directory() / "scenarios"
    return {file.stem: file for file in sorted(folder.glob("*.yaml"))}


def shipped_scenario(name: str) -> Path:
    """Return the file of a scenario that comes with the package; raises ScenarioFileError."""
    found = _shipped()
    stem = str(name).removesuffix(".yaml")
    if stem not in found:
        raise ScenarioFileError(
            f"no file and no scenario of the package: {shown(str(name))}; there are "
            f"{', '.join(found)}"
        )
    return found[stem]


def scenario_file(given: str | os.PathLike[str]) -> Path:
    """Return the absolute path of a scenario file, or of the package's scenario of that name."""
    try:
        path = file_path(given)
        # A folder, such as a bag, is no scenario, and hides none of the package.
        there = path.exists() and not path.is_dir()
    except (OSError, ValueError):
        there = False
    return path.absolute() if there else shipped_scenario(str(given))


# What stands for a scenario: one, the path of a file, or the name of one of the package.
AnyScenario = Scenario | str | Path


def as_scenario(given: object) -> Scenario | None:
    """Return the scenario that is meant: one, or that of a file or a name; raises ScenarioError.

    Raises TypeError for what is none of these.
    """
    if given is None or isinstance(given, Scenario):
        return given
    if isinstance(given, str | os.PathLike):
        return Scenario.from_file(scenario_file(given))
    raise TypeError(f"{shown(given)} is no scenario: give a Scenario or the path of a file")


def scenario_parameter(given: str | Path) -> dict[str, str]:
    """Return the parameter that has a plant follow a scenario; raises ScenarioError.

    ``given`` is as :func:`scenario_file` takes it.
    """
    path = scenario_file(given)
    Scenario.from_file(path)
    return {"time.scenario": str(path)}
