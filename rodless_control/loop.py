"""What happens at one position sample: the reference, the law, and what makes it safe."""

import math
from dataclasses import dataclass

from rodless_control.laws.pid import Command, Pid
from rodless_control.parameters import PidParameters
from rodless_control.setpoint import SetpointFollower


@dataclass(frozen=True)
class Output:
    """The answer to one sample: the reference (m) and the command with its terms."""

    reference: float
    command: Command


class ControlLoop:
    """One command per position sample; time is the samples' own, in ns.

    The counters only grow, so that a fault stays visible after the loop has recovered.
    """

    def __init__(self, parameters: PidParameters) -> None:
        """Wait for the first sample."""
        self.setpoints = SetpointFollower(parameters)
        self._pid = Pid(parameters)
        self.not_finite = self.lost = self.restarts = 0
        self._last: int | None = None

    def configure(self, parameters: PidParameters) -> None:
        """Change the parameters without a jump in the command."""
        self.setpoints.configure(parameters)
        self._pid.configure(parameters)

    def reset(self) -> None:
        """Forget the run so far; the last set-point stays in force."""
        self.setpoints.reset()
        self._pid.reset()
        self._last = None

    def hold(self) -> None:
        """Positions are missing: keep the integrator, take the next sample as a new start."""
        self.lost += 1
        self._pid.hold()

    def sample(self, position: float, time: int) -> Output | None:
        """Return the command for a sample taken at ``time`` (ns), or None to stay safe.

        None means that ``position`` (m) is not finite: the integrator holds. Time that runs
        backwards means that the plant was reset, and so is the loop. A sample whose time
        stands still is answered without integrating.
        """
        if not math.isfinite(position):
            self.not_finite += 1
            self._pid.hold()
            return None
        if self._last is not None and time < self._last:
            self.restarts += 1
            self.reset()
        interval = 0.0 if self._last is None else (time - self._last) * 1e-9
        self._last = time
        reference, velocity = self.setpoints.sample(time * 1e-9, position)
        return Output(reference, self._pid.update(reference, velocity, position, interval))
