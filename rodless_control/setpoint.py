# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""From set-points, as they arrive, to the reference the controller follows."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from rodless_base.parameters import ParameterError
from rodless_control.controller import ReferencePoint
from rodless_control.controller_parameters import ControllerParameters
from rodless_control.references import Constant, Move, Moving, Ramp, Reference, Sine, Step
from rodless_control.trajectory import LARGEST, Trajectory, Waypoint

# The values of reference.type that take no set-points, and what each is made of.
FROM_PARAMETERS = {
    "step": ("reference.start", "reference.target", "reference.at"),
    "sine": ("reference.centre", "reference.amplitude", "reference.frequency", "reference.at"),
}


def reference_from(parameters: ControllerParameters, time: float = 0.0) -> Reference | None:
    """Return the step or sine that ``reference.*`` describe, which starts at ``time`` (s) or later.

    None where ``reference.type`` waits for set-points.
    """
    number = parameters.number
    start = max(number("reference.at"), time)
    match parameters.text("reference.type"):
        case "step":
            return Step(number("reference.start"), number("reference.target"), start)
        case "sine":
            return Sine(
                number("reference.centre"),
                number("reference.amplitude"),
                number("reference.frequency"),
                start,
            )
    return None


@dataclass(frozen=True)
class _Asked:
    """What a change of the limits must leave within."""

    what: str
    least: float  # m
    greatest: float  # m
    way_out: str = "send another set-point"


class SetpointFollower:
    """The reference in force, by ``reference.type``.

    ``setpoint``, ``ramp`` and ``move`` hold the carriage where it is found until a set-point
    comes. One that comes during a ``move`` waits for its end, the latest winning: the jerk limit
    could not be kept otherwise. Commands with a velocity and trajectories take over at once and are
    followed as they are. ``step`` and ``sine`` come from the parameters alone: they refuse all of
    these and forget the last one.
    """

    def __init__(self, parameters: ControllerParameters) -> None:
        """Follow ``parameters``; nothing is known of the carriage yet."""
        self._parameters = parameters
        self._target: float | None = None
        self.reset()

    @property
    def target(self) -> float | None:
        """The set-point in force (m), None where there is none."""
        return self._target

    def reset(self) -> None:
        """Find the carriage anew; the last set-point stays in force."""
        self._reference: Reference | None = None
        self._pending = self._target
        self._time: float | None = None
        # What takes over at the next sample, from a time and a reference, and what it asks for.
        self._successor: tuple[Callable[[float, Reference], Reference], _Asked] | None = None

    def forget(self) -> None:
        """Find the carriage anew, and hold it there until a new set-point comes."""
        self._target = None
        self.reset()

    def configure(self, parameters: ControllerParameters) -> None:
        """Change the parameters; a new type, or a new step or sine, starts at the next sample."""
        old, self._parameters = self._parameters, parameters
        kind = parameters.text("reference.type")
        if kind in FROM_PARAMETERS:
            self._target = None
        made_of = ("reference.type", *FROM_PARAMETERS.get(kind, ()))
        if any(parameters[name] != old[name] for name in made_of):
            self.reset()

    def check(self, parameters: ControllerParameters) -> None:
        """Raise ParameterError for a limit that what is in force, or waits, would leave."""
        if parameters.text("reference.type") in FROM_PARAMETERS:
            return
        low, high = parameters.number("reference.minimum"), parameters.number("reference.maximum")
        # A new type finds the carriage anew: of all that is asked for only the set-point stays.
        stays = parameters.text("reference.type") == self._parameters.text("reference.type")
        for asked in self._asked() if stays else self._set_points():
            for name, limit, reached, excludes in (
                ("reference.minimum", low, asked.least, asked.least < low),
                ("reference.maximum", high, asked.greatest, asked.greatest > high),
            ):
                # A limit that stays is kept already; a way in from outside it may be under way.
                if excludes and limit != self._parameters.number(name):
                    raise ParameterError(
                        f"{name}: {limit:g} m refused, {asked.what} {reached:g} m; "
                        f"{asked.way_out} first"
                    )

    def _set_points(self) -> Iterator[_Asked]:
        if self._target is not None:
            yield _Asked("the set-point in force is", self._target, self._target)

    def _asked(self) -> Iterator[_Asked]:
        """Yield all that the reference is to reach from now on."""
        yield from self._set_points()
        reference, time = self._reference, self._time
        if self._successor is not None:
            yield self._successor[1]
        elif reference is None or time is None:
            return
        elif isinstance(reference, Move) and not self._may_change(time):
            yield _Asked(
                "the move under way goes to", reference.target, reference.target, "wait for its end"
            )
        elif self._pending is None and isinstance(reference, Moving):
            yield _Asked("the command in force is", reference.position, reference.position)
        elif self._pending is None and isinstance(reference, Trajectory):
            yield _Asked("the trajectory in force reaches", *reference.ahead(time))

    def receive(self, target: float) -> None:
        """Take a set-point (m).

        Raises ParameterError outside the travel of ``reference.*``, and where ``reference.type``
        takes no set-points.
        """
        self._check_type(f"set-point: {target:g} m")
        self._parameters.check_travel("set-point", target)
        self._target = self._pending = target
        self._successor = None

    def receive_command(self, position: float, velocity: float) -> None:
        """Take a position (m) with a velocity (m/s), one of a stream; raises as :meth:`receive`.

        The velocity counts for ``reference.velocity_timeout``: what streams may stop.
        """
        self._check_type(f"command: {position:g} m")
        self._parameters.check_travel("command", position)
        fastest = LARGEST["velocity"]
        if not abs(velocity) <= fastest:
            raise ParameterError(
                f"command: {velocity:g} m/s refused, must be within {fastest:g} m/s"
            )
        lasts = self._parameters.number("reference.velocity_timeout")
        self._take_over(
            lambda time, _: Moving(position, velocity, time + lasts),
            _Asked("the command in force is", position, position),
        )

    def receive_trajectory(self, points: Sequence[Waypoint], start: float | None = None) -> None:
        """Follow ``points``, whose times count from ``start`` (s), or from the next sample on.

        The way to the first point that is still ahead begins where the reference is. Raises
        ParameterError for points that are no trajectory, leave the travel, on the way to the first
        too, or are over, and as :meth:`receive`. Where the reference has moved on before the next
        sample, or is not known before it, the way to the first point waits at an end of the travel.
        """
        self._check_type("trajectory")
        try:
            given = Trajectory(points)
            low, high = given.extremes()
        except ValueError as error:
            raise ParameterError(f"trajectory: refused, {error}") from error
        for position in (low, high):
            self._parameters.check_travel("trajectory", position)
        if start is not None and not abs(start) <= LARGEST["time"]:
            raise ParameterError(f"trajectory: refused, its start, {start!r} s, is no time")
        end = points[-1].time if start is None else start + points[-1].time
        if start is not None and self._time is not None and end < self._time:
            raise ParameterError(
                f"trajectory: refused, it ended at {end:g} s, now it is {self._time:g} s; a stamp "
                "of 0 starts at once"
            )
        if points[0].time < 0.0:
            raise ParameterError(
                f"trajectory: refused, point 1: time {points[0].time:g} s is before its start"
            )

        def joined(time: float, now: Reference) -> Trajectory:
            return given.joined(now, time, time if start is None else start, self._travel())

        self._check_way(joined)
        self._take_over(joined, _Asked("the trajectory in force reaches", low, high))

    def _check_way(self, joined: Callable[[float, Reference], Trajectory]) -> None:
        """Refuse what would leave the travel if it began now; what has moved since may not."""
        if self._reference is None or self._time is None:
            return
        reached = joined(self._time, self._reference).excess()
        if reached is not None:
            here = self._reference.sample(self._time)[0]
            low, high = self._travel()
            limit, value = ("minimum", low) if reached < low else ("maximum", high)
            raise ParameterError(
                f"trajectory: refused, from {here:g} m, where the reference is, it would reach "
                f"{reached:g} m before its first point ahead, beyond reference.{limit} "
                f"({value:g} m); give that point another time or velocity"
            )

    def _travel(self) -> tuple[float, float]:
        number = self._parameters.number
        return number("reference.minimum"), number("reference.maximum")

    def _take_over(self, successor: Callable[[float, Reference], Reference], asks: _Asked) -> None:
        self._target = self._pending = None
        self._successor = successor, asks

    def _check_type(self, what: str) -> None:
        kind = self._parameters.text("reference.type")
        if kind in FROM_PARAMETERS:
            raise ParameterError(
                f"{what} ignored, reference.type is {kind}; set-points need setpoint, ramp or move"
            )

    def sample(self, time: float, position: float) -> ReferencePoint:
        """Return the reference at ``time`` (s), the carriage being at ``position`` (m)."""
        if self._reference is None:
            self._reference = self._first(time, position)
        self._time = time
        if self._successor is not None:
            take_over, _ = self._successor
            self._reference, self._successor = take_over(time, self._reference), None
        elif self._pending is not None and self._may_change(time):
            self._reference = self._towards(self._pending, time, self._reference)
            self._pending = None
        return ReferencePoint(*self._reference.sample(time))

    def _first(self, time: float, position: float) -> Reference:
        return reference_from(self._parameters, time) or Constant(position)

    def _may_change(self, time: float) -> bool:
        current = self._reference
        return not isinstance(current, Move) or time >= current.at + current.duration

    def _towards(self, target: float, time: float, current: Reference) -> Reference:
        start, _ = current.sample(time)
        number = self._parameters.number
        match self._parameters.text("reference.type"):
            case "ramp":
                return Ramp(start, target, number("reference.velocity"), time)
            case "move":
                return Move(
                    start,
                    target,
                    number("reference.velocity"),
                    number("reference.acceleration"),
                    number("reference.jerk"),
                    time,
                )
        return Constant(target)
