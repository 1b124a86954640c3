# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What an experiment needs of a rig: open-loop and closed-loop runs, wherever they happen."""

from typing import NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from rodless_base.measurement import Measurement
from rodless_control import ControllerParameters, PidParameters
from rodless_control.references import Reference
from rodless_lab.simulation.closed_loop import ClosedLoopTrace, closed_loop
from rodless_sim import RigParameters, Trace, simulate
from rodless_sim.instruments.sampling import Sampling
from rodless_sim.physics.cylinder import piston_area
from rodless_sim.timing import nanoseconds


class OpenLoop(Protocol):
    """Runs like :func:`rodless_sim.simulate`, seen as in :func:`rodless_lab.closed_loop`.

    Position, pressures and force are what the instruments of ``sensors.*`` read, the rest is true.
    """

    def __call__(
        self,
        parameters: RigParameters,
        voltages: npt.ArrayLike,
        period: float,
        position: float | None = None,
        /,
    ) -> Trace:
        """Drive a rig at rest with voltages (V, shape (n,)), each held for ``period`` s."""


class ClosedLoop(Protocol):
    """Runs like :func:`rodless_lab.closed_loop`."""

    def __call__(
        self,
        rig_parameters: RigParameters,
        law: PidParameters | ControllerParameters,
        reference: Reference,
        duration: float,
        period: float,
        position: float | None = None,
        /,
    ) -> ClosedLoopTrace:
        """Control a rig at rest along ``reference`` for ``duration`` s."""


class Runner(NamedTuple):
    """Where runs happen."""

    open_loop: OpenLoop
    closed_loop: ClosedLoop


def open_loop(
    parameters: RigParameters,
    voltages: npt.ArrayLike,
    period: float,
    position: float | None = None,
) -> Trace:
    """Drive a rig in this process; see :class:`OpenLoop`."""
    run = simulate(parameters, voltages, period, position)
    return as_read(run, parameters, nanoseconds(period))


def as_read(run: Trace, parameters: RigParameters, period: int) -> Trace:
    """Return a run, of samples ``period`` ns apart, as the plant node publishes it."""
    sampling = Sampling(parameters)
    supply = parameters.number("supply.pressure")  # whose reading a trace does not have
    true = zip(run.position.tolist(), run.pressure_a.tolist(), run.pressure_b.tolist(), strict=True)
    seen = [sampling.read(Measurement(k * period, *at, supply)) for k, at in enumerate(true)]
    _, position, pressure_a, pressure_b, _ = np.array(seen, dtype=np.float64).T.copy()
    read = {
        "position": position,
        "pressure_a": pressure_a,
        "pressure_b": pressure_b,
        "force": piston_area(parameters) * (pressure_a - pressure_b),
    }
    return Trace(**{**run.columns(), **read})


IN_PROCESS = Runner(open_loop, closed_loop)
