# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A sweep's study file, and the rows it stands for."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from math import prod
from pathlib import Path

from rodless_base.columns import quantities
from rodless_base.one_line import described, in_one_line, shown
from rodless_base.parameters import ParameterError, Value
from rodless_control import ControllerParameters
from rodless_control.laws import LAWS
from rodless_control.parameters import LAW
from rodless_lab.simulation.closed_loop import ClosedLoopTrace, as_law
from rodless_lab.simulation.design import (
    LARGEST_SEED,
    METHODS,
    MOST_ROWS,
    Choice,
    DesignError,
    Dimension,
    Range,
    named,
    seed_of,
    shares,
)
from rodless_lab.studies.base import EACH_ITS_SEED, SEED, Base, read_base, refuse_of_both
from rodless_lab.studies.errors import StudyError
from rodless_lab.studies.fields import Fields
from rodless_lab.studies.idle import idle, idle_parameters
from rodless_lab.studies.sensitivity import SALTELLI, saltelli
from rodless_lab.studies.shipped import find_file
from rodless_sim.physics.state import State

GRID = "grid"
DESIGNS = (GRID, *METHODS, SALTELLI)

TRACES = tuple(quantity.name for quantity in (*quantities(State), *quantities(ClosedLoopTrace)))

# The unit of an axis of factors.
FACTOR = "1"

# What the file of a study may hold.
FIELDS = ("base", "sensors", "set", "vary", "design", "run", "traces")


@dataclass(frozen=True)
class Row:
    """One run of a study."""

    number: int
    levels: dict[str, object]  # by axis: the value, or the factor
    base: Base


@dataclass(frozen=True)
class Study:
    """A study as its file describes it: :func:`read_study` reads one."""

    name: str
    base: Base
    dimensions: tuple[Dimension, ...]
    method: str
    count: int  # rows; of a Saltelli design, the base samples it is made of
    seed: int
    trace_columns: tuple[str, ...] = ()
    trace_every: int = 1

    @cached_property
    def levels(self) -> list[tuple[object, ...]]:
        """What each row gives to each axis; raises DesignError."""
        if self.method == GRID:
            axes = [_levels(one) for one in self.dimensions]
            if prod(map(len, axes)) > MOST_ROWS:
                raise DesignError(f"a grid of more than {MOST_ROWS} rows refused: take fewer")
            return list(product(*axes))
        if self.method == SALTELLI:
            design = saltelli(len(self.dimensions), self.count, self.seed)
        else:
            design = shares(self.method, self.count, len(self.dimensions), self.seed)
        return [
            tuple(one.axis.at(share) for one, share in zip(self.dimensions, row, strict=True))
            for row in design.tolist()
        ]

    @property
    def _sharing(self) -> int:
        """How many rows have one seed: of a Saltelli design those that differ in an axis alone.

        With noise of their own the difference would be taken for what the axis does.
        """
        return len(self.dimensions) + 2 if self.method == SALTELLI else 1

    @cached_property
    def with_fractions(self) -> frozenset[int]:
        """The places of the axes with numbers that are not whole, in any row."""
        return frozenset(
            place
            for place, levels in enumerate(zip(*self.levels, strict=True))
            if any(isinstance(one, float) for level in levels for one in several(level))
        )

    @cached_property
    def _bases(self) -> dict[str, dict[str, Value]]:
        """Of each law, the value of each parameter that all rows have: factors multiply it."""
        both = {law: {**self.base.rig, **one} for law, one in self.base.by_law.items()}
        names = self.base.names
        return {law: {name: values[name] for name in names} for law, values in both.items()}

    def __len__(self) -> int:
        return len(self.levels)

    @property
    def numbers(self) -> int:
        """How many numbers the traces of a row have."""
        samples = round(self.base.last / self.base.period) + 1
        return len(self.trace_columns) * (samples // self.trace_every + 1)

    def unit(self, axis: Dimension) -> str:
        """Return the unit of an axis, 1 of factors, empty where it varies unlike parameters."""
        if axis.factor:
            return FACTOR
        declared = {**self.base.rig.DECLARATIONS, **self.base.controller.DECLARATIONS}
        units = {declared[name].unit for name in axis.names(self.base.names)}
        return units.pop() if len(units) == 1 else ""

    def row(self, number: int) -> Row:
        """Return one row; raises ParameterError where its values are no rig or controller."""
        levels = self.levels[number]
        values: dict[str, object] = {SEED: seed_of(self.seed, number // self._sharing)}
        named = {one.name: level for one, level in zip(self.dimensions, levels, strict=True)}
        base = self._bases[str(named.get(LAW, self.base.controller.text(LAW)))]
        for one, level in zip(self.dimensions, levels, strict=True):
            values.update(one.values(base, level))
        return Row(number, named, self.base.with_values(values))


def several(level: object) -> tuple[object, ...]:
    """Return the values of a parameter that has several, or its one."""
    return level if isinstance(level, tuple) else (level,)


def _levels(dimension: Dimension) -> Sequence[object]:
    """Return the levels of an axis of a grid; raises DesignError, which names the axis."""
    with named(dimension.name):
        return dimension.axis.levels()


def read_study(given: str | Path) -> Study:
    """Read a study and check all of its rows.

    Parameters
    ----------
    given
        A YAML file (docs/sweeps.md), or the name of a study that ships with the package.

    Raises
    ------
    StudyError
        In one line with file, key, value and the way out; nothing has run then.
    """
    path = find_file("studies", given)
    fields = Fields.of_file(path, FIELDS)
    study = study_of(fields, path)
    check_set(fields.below("set"), [study])
    return study


def study_of(fields: Fields, path: Path, runs: bool = True) -> Study:
    """Take a study from the fields of its file and check the rows that it ``runs``.

    Raises StudyError.
    """
    base = read_base(fields, path.parent)
    design = fields.below("design")
    method = design.text("method", GRID)
    if method not in DESIGNS:
        raise design.error("method", f"{shown(method)} refused, must be {', '.join(DESIGNS)}")
    if method == GRID and "rows" in design.values:
        raise design.error("rows", "refused: the rows of a grid follow from the counts in vary")
    if method != GRID and "rows" not in design.values:
        raise design.error("rows", f"missing; give how many rows of a {method} design to run")
    dimensions = _dimensions(
        fields.below("vary"), base, fields.below("set").values, counted=method == GRID
    )
    count = design.whole("rows", 1, 1, MOST_ROWS)
    seed = design.whole("seed", 1, 0, LARGEST_SEED)
    design.end()
    columns, every = _traces(fields.below("traces"))
    study = Study(path.stem, base, dimensions, method, count, seed, columns, every)
    if runs:
        check_rows(study, fields.where)
    return study


def check_set(fields: Fields, studies: Sequence[Study]) -> None:
    """Raise StudyError for what is set and read by no run of any of ``studies``."""
    unused = set.intersection(*(idle_parameters(study.base) for study in studies))
    for name in sorted(unused & fields.values.keys()):
        raise fields.error(name, idle([name]))


def _traces(fields: Fields) -> tuple[tuple[str, ...], int]:
    columns, every = fields.list_of("columns"), fields.whole("every", 10, 1)
    fields.end()
    for name in columns:
        if name not in TRACES:
            raise fields.error("columns", f"{shown(name)} refused, there are {', '.join(TRACES)}")
    return tuple(map(str, columns)), every


def _dimensions(
    fields: Fields, base: Base, set_for_all: Collection[str], counted: bool
) -> tuple[Dimension, ...]:
    found: list[Dimension] = []
    owners: dict[str, str] = {}
    unused = idle_parameters(base)
    bases: list[Mapping[str, object]] = [base.rig, *base.by_law.values()]
    for name in fields.values:
        one = read_dimension(fields, name, "" if counted else "design.rows says how many")
        names = one.names(base.names)
        if not names:
            raise fields.error(name, base.unknown(name).partition(": ")[2])
        if SEED in names:
            raise fields.error(name, f"{SEED} {EACH_ITS_SEED}")
        if "reference.type" in names:
            raise fields.error(name, "cannot vary within a study; make one study for each")
        if unused.issuperset(names):
            raise fields.error(name, idle(names))
        values = [one_of[name] for one_of in bases for name in names if name in one_of]
        if one.factor and not any(map(_is_changed_by_factors, values)):
            raise fields.error(name, "factor: refused, a factor changes nothing of 0; give values")
        if LAW in names and name != LAW:
            raise fields.error(name, f"{LAW} cannot vary with others; name it by itself")
        for parameter in names:
            refuse_of_both(fields, name, parameter, base.by_law)
            if parameter in owners:
                other = in_one_line(owners[parameter])
                raise fields.error(name, f"{parameter} is varied by {other} too; keep one")
            if parameter in set_for_all and not one.factor:
                raise fields.error(name, f"{parameter} is set, too; keep one")
            owners[parameter] = name
        found.append(one)
    return tuple(found)


def _is_changed_by_factors(value: object) -> bool:
    return any(one != 0 for one in several(value))


def read_dimension(fields: Fields, name: str, uncounted: str = "") -> Dimension:
    """Take one axis: a list of values, or a range; raises StudyError.

    ``uncounted`` says why a range has no count, if it has none.
    """
    given = fields.values[name]
    try:
        if isinstance(given, list):
            values = [tuple(value) if isinstance(value, list) else value for value in given]
            return Dimension(name, Choice(tuple(values)))
        own = fields.below(name)
        if "count" in own.values and uncounted:
            raise own.error("count", f"refused: counts are for grids; {uncounted}")
        scale = own.text("scale", "linear")
        if scale not in ("linear", "logarithmic"):
            raise own.error("scale", f"{shown(scale)} refused, must be linear or logarithmic")
        for end in ("from", "to"):
            if end not in own.values:
                raise own.error(end, "missing; give from and to, or a list of values")
        axis = Range(
            own.number("from", 0.0),
            own.number("to", 0.0),
            own.whole("count", 0),
            scale == "logarithmic",
        )
        factor = own.flag("factor")
        own.end()
    except DesignError as error:
        raise fields.error(name, str(error)) from error
    return Dimension(name, axis, factor)


def check_rows(study: Study, where: str) -> None:
    """Raise StudyError, which begins with ``where``, for a row that no rig or law can be."""
    try:
        count = len(study)
    except DesignError as error:
        raise StudyError(f"{where}: design: {error}") from error
    made: set[tuple[Value, ...]] = set()
    for number in range(count):
        place = f"row {number} of {count}"
        try:
            row = study.row(number)
        except (ParameterError, DesignError) as error:
            raise StudyError(f"{where}: vary: {place}: {described(error)}") from error
        try:
            row.base.check_begins()
            _check_law(row.base.controller, made)
        except ParameterError as error:
            raise StudyError(f"{where}: {place}: {described(error)}") from error


def _check_law(controller: ControllerParameters, made: set[tuple[Value, ...]]) -> None:
    """Raise ParameterError for values of which their law cannot be made, unless it was ``made``."""
    # The laws of this package can, of all that their sets take, and making one takes milliseconds.
    if controller[LAW] in LAWS:
        return
    values = (controller[LAW], *controller.of_law().values())
    if values not in made:
        as_law(controller)
        made.add(values)
