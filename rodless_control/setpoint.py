"""From set-points, as they arrive, to the reference the controller follows."""

from rodless_base.parameters import ParameterError
from rodless_control.controller import ReferencePoint
from rodless_control.controller_parameters import ControllerParameters
from rodless_control.references import Constant, Move, Ramp, Reference, Sine, Step

# The values of reference.type that take no set-points.
FROM_PARAMETERS = ("step", "sine")


class SetpointFollower:
    """The reference in force, by ``reference.type``.

    ``setpoint``, ``ramp`` and ``move`` hold the carriage where it is found until a set-point
    comes. One that comes during a ``move`` waits for its end, the latest winning: the jerk limit
    could not be kept otherwise. ``step`` and ``sine`` come from the parameters alone: they refuse
    set-points and forget the last one.
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

    def forget(self) -> None:
        """Find the carriage anew, and hold it there until a new set-point comes."""
        self._target = None
        self.reset()

    def configure(self, parameters: ControllerParameters) -> None:
        """Change the parameters; a new type, or a new step or sine, starts at the next sample."""
        old, self._parameters = self._parameters, parameters
        kind = parameters.text("reference.type")
        changed = any(parameters[n] != old[n] for n in parameters if n.startswith("reference."))
        if kind in FROM_PARAMETERS:
            self._target = None
        if kind != old.text("reference.type") or (changed and kind in FROM_PARAMETERS):
            self.reset()

    def check(self, parameters: ControllerParameters) -> None:
        """Raise ParameterError where the set-point in force is outside the travel of a change."""
        target = self._target
        if target is None or parameters.text("reference.type") in FROM_PARAMETERS:
            return
        low, high = parameters.number("reference.minimum"), parameters.number("reference.maximum")
        for name, limit, excludes in (
            ("reference.minimum", low, target < low),
            ("reference.maximum", high, target > high),
        ):
            if excludes:
                raise ParameterError(
                    f"{name}: {limit:g} m refused, the set-point in force is "
                    f"{target:g} m; send another set-point first"
                )

    def receive(self, target: float) -> None:
        """Take a set-point (m).

        Raises ParameterError outside the travel of ``reference.*``, and where ``reference.type``
        takes no set-points.
        """
        kind = self._parameters.text("reference.type")
        if kind in FROM_PARAMETERS:
            raise ParameterError(
                f"set-point: {target:g} m ignored, reference.type is {kind}; "
                "set-points need setpoint, ramp or move"
            )
        self._parameters.check_travel("set-point", target)
        self._target = self._pending = target

    def sample(self, time: float, position: float) -> ReferencePoint:
        """Return the reference at ``time`` (s), the carriage being at ``position`` (m)."""
        if self._reference is None:
            self._reference = self._first(time, position)
        if self._pending is not None and self._may_change(time):
            self._reference = self._towards(self._pending, time, self._reference)
            self._pending = None
        return ReferencePoint(*self._reference.sample(time))

    def _first(self, time: float, position: float) -> Reference:
        number = self._parameters.number
        start = max(number("reference.at"), time)
        match self._parameters.text("reference.type"):
            case "step":
                return Step(number("reference.start"), number("reference.target"), start)
            case "sine":
                return Sine(
                    number("reference.centre"),
                    number("reference.amplitude"),
                    number("reference.frequency"),
                    start,
                )
        return Constant(position)

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
