# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What all runs of a study begin with: a rig, its controller, and how long they run."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from rodless_base.constants import SECONDS_PER_NANOSECOND
from rodless_base.one_line import described, in_one_line, shown
from rodless_base.parameter_file import check_for_one_rig, preset_names, read_parameter_file
from rodless_base.parameters import ParameterError, errors_of_file
from rodless_control import ControllerParameters
from rodless_control.parameters import LAW
from rodless_control.references import Reference
from rodless_control.setpoint import FROM_PARAMETERS, reference_from
from rodless_lab.simulation.closed_loop import Loop, sample_count
from rodless_lab.studies.errors import StudyError
from rodless_lab.studies.fields import Fields
from rodless_sim import RigParameters
from rodless_sim.instruments.instruments import sensors_of
from rodless_sim.timing import nanoseconds, step_nanoseconds

SEED = "sensors.seed"
SCENARIO = "time.scenario"
EACH_ITS_SEED = "refused: each row has a seed of its own, which design.seed draws"


@dataclass(frozen=True)
class Base:
    """Rig and controller of a run, and its times in s."""

    rig: RigParameters
    controller: ControllerParameters
    duration: float
    period: float
    since: float  # when peak and RMS begin to count
    # Of each law that varies within the study, by what controller.law names; empty where none does.
    controllers: Mapping[str, ControllerParameters] = field(default_factory=dict)

    @property
    def by_law(self) -> Mapping[str, ControllerParameters]:
        """The controller of each law that varies, or the one there is."""
        return self.controllers or {self.controller.text(LAW): self.controller}

    def with_values(self, values: Mapping[str, object]) -> "Base":
        """Return a copy with values for either node; raises ParameterError."""
        own = {name: value for name, value in values.items() if name in self.rig}
        others = {name: value for name, value in values.items() if name not in self.rig}
        controller = self.controller
        if self.controllers and LAW in others:
            controller = self.controllers[str(others.pop(LAW))]
        return replace(
            self,
            rig=self.rig.with_values(own) if own else self.rig,
            controller=controller.with_values(others) if others else controller,
        )

    @property
    def reference(self) -> Reference:
        """What the carriage follows."""
        found = reference_from(self.controller)
        assert found is not None, "checked when the study was read"
        return found

    def loop(self) -> Loop:
        """Return the loop of law and reference; raises as :func:`rodless_lab.closed_loop`."""
        return Loop(self.controller, self.reference, self.duration, self.period)

    def check_begins(self) -> None:
        """Raise ParameterError where the reference begins to move once the run is over."""
        begin, last = self.controller.number("reference.at"), self.last
        if begin >= last:
            raise ParameterError(
                f"reference.at: {begin:g} s refused, the run has ended by then; must be less than "
                f"{last:g} s, its last sample, or 0 for a reference that stands"
            )

    @property
    def last(self) -> float:
        """When the last sample of a run is, in s."""
        span = step_nanoseconds(self.period, "run.period")
        return (sample_count(nanoseconds(self.duration), span) - 1) * span * SECONDS_PER_NANOSECOND

    @property
    def names(self) -> list[str]:
        """The names of all parameters that each law of the study has."""
        others = self.controllers.values()
        own = [name for name in self.controller if all(name in one for one in others)]
        return [*self.rig, *own]

    def unknown(self, name: str) -> str:
        """Say that ``name`` is a parameter of neither node, or not one of every law."""
        without = [law for law, one in self.controllers.items() if name not in one]
        if 0 < len(without) < len(self.controllers):
            return f"{name}: {', '.join(without)} has no such parameter; vary it in another study"
        own = name in RigParameters.DECLARATIONS or not ControllerParameters.foreign(name)
        return (type(self.controller) if own else RigParameters).unknown(name)


def read_base(fields: Fields, folder: Path) -> Base:
    """Take ``base``, ``sensors``, ``set`` and ``run`` of a study's file; raises StudyError.

    A parameter file that ``base`` names stands in ``folder``, where the study does.
    """
    given = fields.text("base", "calibrated")
    choice = fields.text("sensors", "base")
    try:
        sensors = sensors_of(choice)
    except ValueError as error:
        raise fields.error("sensors", str(error)) from error
    changes = dict(fields.below("set").values)
    if SEED in changes:
        raise fields.error("set", f"{SEED} {EACH_ITS_SEED}")
    laws = _laws(fields, changes, given, folder)
    try:
        kinds = {law: ControllerParameters.for_law(law) for law in laws}
    except ParameterError as error:
        varies = LAW in fields.below("vary").values
        key = "set" if LAW in changes else "vary" if varies else "base"
        raise StudyError(f"{fields.where}: {key}: {described(error)}") from error
    try:
        rig, controllers = _sets(given, folder, kinds)
    except ParameterError as error:
        raise StudyError(f"{fields.where}: base: {described(error)}") from error
    if scenario := rig.text(SCENARIO):
        raise fields.error(
            "base",
            f"{SCENARIO}: {shown(scenario)} refused, no run of a study follows a scenario; leave "
            "it out",
        )
    run = fields.below("run")
    times = run.number("duration", 6.0), run.number("period", 1e-3), run.number("since", 0.0)
    run.end()
    rig = rig.with_values(sensors)
    for name in changes:
        refuse_of_both(fields, "set", name, controllers)
    # What nobody has is refused by the node whose it would be.
    foreign = {name for name in changes if all(one.foreign(name) for one in controllers.values())}
    own = {name: value for name, value in changes.items() if name in rig or name in foreign}
    others = {name: value for name, value in changes.items() if name not in own}
    try:
        rig = rig.with_values(own)
        found = _set(controllers, {"reference.type": "step", **others})
    except ParameterError as error:
        raise StudyError(f"{fields.where}: set: {described(error)}") from error
    _check_period(fields, rig, times[1])
    base = Base(rig, found[laws[0]], *times, found if len(laws) > 1 else {})
    for controller in found.values():
        check_reference(fields, replace(base, controller=controller))
    return base


def refuse_of_both(
    fields: Fields, key: str, name: str, controllers: Mapping[str, ControllerParameters]
) -> None:
    """Raise StudyError for a name that the rig has and a law, too: which is meant is not said."""
    for law, controller in controllers.items():
        if name in RigParameters.DECLARATIONS and name in controller.LAW_CLASS.PARAMETERS:
            raise fields.error(key, f"{name}: the rig has it, and {law} too; rename the law's")


def _laws(fields: Fields, changes: Mapping[str, object], base: str, folder: Path) -> list[str]:
    """Return the laws of a study: those that vary, or the one that is set or that the base has."""
    varied = fields.below("vary").values.get(LAW)
    if varied is None:
        return [str(changes[LAW] if LAW in changes else _law_of(base, folder))]
    if LAW in changes:
        raise fields.error("set", f"{LAW} refused: it varies; keep one")
    if not isinstance(varied, list) or not varied:
        raise fields.error("vary", f"{LAW}: must be a list of laws")
    return list(dict.fromkeys(map(str, varied)))


def _law_of(base: str, folder: Path) -> object:
    """Return the law that a parameter file names; that of a preset or a file without is ``pid``."""
    if base in preset_names():
        return "pid"
    try:
        return read_parameter_file(folder / base, ControllerParameters.NODE).get(LAW, "pid")
    except (OSError, ValueError):  # told where the whole file is read
        return "pid"


def _set(
    controllers: Mapping[str, ControllerParameters], values: Mapping[str, object]
) -> dict[str, ControllerParameters]:
    """Give each controller what is its own of ``values``; raises ParameterError."""
    known = {name for one in controllers.values() for name in one}
    return {
        law: one.with_values(
            {name: value for name, value in values.items() if name in one or name not in known}
        )
        for law, one in controllers.items()
    }


def _check_period(fields: Fields, rig: RigParameters, period: float) -> None:
    """Raise StudyError for a period (s) in which the valve of the rig's node would close."""
    timeout = rig.number("valve.command_timeout")
    if period > timeout:
        raise fields.error(
            "run",
            f"period: {period:g} s refused, longer than valve.command_timeout ({timeout:g} s), "
            "after which a valve closes; make it shorter, or that longer in a base of your own",
        )


def check_reference(fields: Fields, base: Base) -> None:
    """Raise StudyError where the controller would wait for set-points, or the times cannot be."""
    kind = base.controller.text("reference.type")
    if kind not in FROM_PARAMETERS:
        wanted = " or ".join(FROM_PARAMETERS)
        raise fields.error(
            "set",
            f"reference.type: {kind} refused, it waits for set-points; must be {wanted}",
        )
    try:
        times = base.loop().times
    except ParameterError as error:  # a law that cannot be made
        raise StudyError(f"{fields.where}: {described(error)}") from error
    except ValueError as error:
        raise fields.error("run", described(error)) from error
    if not 0.0 <= base.since <= times[-1]:
        raise fields.error(
            "run", f"since: {base.since:g} s refused, must be within the run, 0 to {times[-1]:g} s"
        )


def _sets(
    base: str, folder: Path, kinds: Mapping[str, type[ControllerParameters]]
) -> tuple[RigParameters, dict[str, ControllerParameters]]:
    """Return rig and controllers, by law, as the base has them; raises ParameterError."""
    if base in preset_names():
        return RigParameters.preset(base), {law: kind.preset(base) for law, kind in kinds.items()}
    path = folder / base
    if not _exists(path):
        raise ParameterError(
            f"{in_one_line(base)}: neither a preset ({', '.join(preset_names())}) nor a parameter "
            f"file in {folder}"
        )
    with errors_of_file(path):
        check_for_one_rig(path)
    return RigParameters.from_file(path), {law: kind.from_file(path) for law, kind in kinds.items()}


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except OSError:  # no file can have this name
        return False
