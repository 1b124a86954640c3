# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Friction of a measured run: points of eq. (30), stick-slip events, and the fit of both."""

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from rodless_lab.identification.friction.bristle_motion import BristleMotion
from rodless_lab.identification.friction.fit import FINEST_FORCE, FrictionFit, fit_friction
from rodless_lab.identification.friction.form import FrictionForm
from rodless_lab.identification.friction.rest import Give, give_at_rest, verdict_of
from rodless_lab.identification.friction.stick_slip import StickSlipEvents, stick_slip_events
from rodless_lab.identification.friction.uniform_motion import (
    WINDOW,
    UniformPart,
    uniform_parts,
)
from rodless_lab.identification.plausible import check_run
from rodless_lab.runs.measured_run import MeasuredRun, UninformativeRunError
from rodless_sim import RigParameters
from rodless_sim.instruments.instruments import DATA_SHEET, PRESSURE_RANGE
from rodless_sim.physics import rail
from rodless_sim.physics.bristles import LUGRE
from rodless_sim.physics.cylinder import piston_area

Array = npt.NDArray[np.float64]

# Change of speed over a stretch, as a share, up to which it gives a point: the force of its own
# acceleration is taken out.
STEADY = 0.15

# How far points are from the curve where no sensor has an error (N, root mean square of four rigs;
# 0.19 at most): speed and force are means with different weights of a motion that STEADY lets vary.
POINT_ACCURACY = 0.08

# How far the turn of the force is from the curve's own, in every event alike (N): inertia lets a
# breakaway overshoot by 2.3 (m² r² / c)^(1/3) for a force rising at r over a curvature c, 0.1 N for
# 10 N/s on this rig.
EVENT_ACCURACY = 0.12

# Bristles let go and catch otherwise than eq. (29) by this share of the force (rigs of 2e6 N/m).
BRISTLE_EVENT_ACCURACY = 0.05

# Two biases, each anywhere within ±b, differ by less than this many b in 98 of 100 cases.
BIAS_DIFFERENCE = 2.0 * (1.0 - math.sqrt(0.02))


@dataclass(frozen=True)
class FrictionPoints:
    """Uniform motion (m/s, N, with standard errors; shape (n,)) and stick-slip events of a run.

    ``give`` is how the carriage moves while it sticks; ``motion`` is what bristles follow, where
    the parameters say that there are any.
    """

    speeds: Array
    speed_errors: Array
    forces: Array
    force_errors: Array
    events: StickSlipEvents
    give: Give | None
    reason: str
    motion: BristleMotion | None = None


def friction_points(run: MeasuredRun, parameters: RigParameters) -> FrictionPoints:
    """Read uniform motion and stick-slip from ``run``.

    Of ``parameters`` bore, moving mass, the rail's tilt, the lag of the pressure sensors and the
    bristles are used; ``reason`` says why where there is no uniform motion. Raises ValueError for a
    run of no length.

    Examples
    --------
    >>> from rodless_lab.runs.measured_run import run_of_trace
    >>> from rodless_sim import simulate
    >>> rig = RigParameters()
    >>> run = run_of_trace(simulate(rig, [5.6] * 2000, 1e-3, position=0.01), 621325.0)
    >>> points = friction_points(run, rig)
    >>> friction = 12.0 + 4500.0 * points.speeds  # Table 2
    >>> bool(np.allclose(points.forces, friction, atol=0.3))
    True
    """
    area = piston_area(parameters)
    lag = parameters.number("sensors.pressure_lag")
    # What of the pressures' force friction has to bear: a tilted rail bears its own share.
    force = area * (run.pressure_a - run.pressure_b) - rail.of(parameters).weight
    found = uniform_parts(run.time, run.position, tolerance=STEADY)
    readings = [_force(run.time, force, part, lag) for part in found.parts]
    mass = parameters.number("cylinder.moving_mass")
    speeds = np.array([part.speed for part in found.parts])
    forces = np.array(
        [
            mean - mass * part.acceleration
            for (mean, _), part in zip(readings, found.parts, strict=True)
        ]
    )
    force_errors = np.array([error for _, error in readings])
    motion = None
    if parameters.text("friction.dynamics") == LUGRE:
        motion = BristleMotion.of(parameters, run.position, run.period, found.parts)
        force_errors = np.hypot(force_errors, motion.force_errors(speeds, forces))
    return FrictionPoints(
        speeds=speeds,
        speed_errors=np.array([part.speed_error for part in found.parts]),
        forces=forces,
        force_errors=force_errors,
        events=stick_slip_events(run.time, run.position, force, lag),
        give=give_at_rest(run.time, run.position, force),
        reason=found.reason,
        motion=motion,
    )


def _force(time: Array, force: Array, part: UniformPart, lag: float) -> tuple[float, float]:
    """Mean force over a part in N, the sensors' lag removed, and its standard error."""
    local = time[part.first : part.last] - time[part.first : part.last].mean()
    line = np.polynomial.Polynomial.fit(local, force[part.first : part.last], 1)
    mean, slope = np.resize([*line.convert().coef, 0.0], 2)  # it leaves a slope of 0 out
    scatter = float(np.std(force[part.first : part.last] - line(local), ddof=2))
    error = math.hypot(scatter / math.sqrt(len(local)), FINEST_FORCE)
    return float(mean + lag * slope), error


def identify_friction(run: MeasuredRun, parameters: RigParameters) -> FrictionFit:
    """Identify both directions' friction, in the form of ``parameters``, from one run.

    The intervals hold the noise of the run and, by the ``sensors.*`` of ``parameters``, what its
    noise cannot show: a bias of the pressure sensors moves F_s and F_c of both directions by one
    force, a nonlinearity of the position sensor moves the slope B.

    Parameters
    ----------
    run
        The measured run.
    parameters
        What is taken as known: ``friction.form`` with its own constants, bore, moving mass, the
        rail's tilt and ``sensors.*``; and the stroke, which no run is longer than.

    Raises
    ------
    UninformativeRunError
        For a run without uniform motion.
    RunError
        For a run that is of no such rig.

    Examples
    --------
    >>> from rodless_lab.runs.measured_run import run_of_trace
    >>> from rodless_sim import simulate
    >>> rig = RigParameters()
    >>> voltages = np.repeat([5.4, 5.5, 5.6, 5.7], 1500)
    >>> run = run_of_trace(simulate(rig, voltages, 1e-3, position=0.01), 621325.0)
    >>> fit = identify_friction(run, rig)
    >>> fit.forward.viscous.covers(rig.number("friction.forward.viscous"))
    True
    """
    check_run(run, parameters, WINDOW, absolute=False)
    return fit_points(friction_points(run, parameters), parameters)


def fit_points(points: FrictionPoints, parameters: RigParameters) -> FrictionFit:
    """Fit what :func:`friction_points` read; see :func:`identify_friction`."""
    nonlinearity = 0.5 * speed_stretch(parameters) * np.abs(points.speeds)
    if not len(points.speeds):
        raise UninformativeRunError(f"no uniform motion: {points.reason}")
    least, most = bias_force(parameters), float(np.quantile(np.abs(points.forces), 0.9))
    if most < least:
        raise UninformativeRunError(
            f"the pressures push the moving carriage by {most:.3g} N at most, "
            f"less than the {least:.3g} N that a bias of their sensors makes: no friction is told "
            "from that; are both sensors connected, each to its chamber?"
        )
    events = points.events
    share = 0.0 if points.motion is None else BRISTLE_EVENT_ACCURACY
    fit = fit_friction(
        points.speeds,
        points.forces,
        speed_errors=np.hypot(points.speed_errors, nonlinearity),
        force_errors=points.force_errors,
        breakaways=events.breakaways,
        breakaway_errors=_alike(events.breakaways, events.breakaway_errors, share),
        stops=events.stops,
        stop_errors=_alike(events.stops, events.stop_errors, share),
        form=FrictionForm.of(parameters),
        allowance=POINT_ACCURACY,
        motion=points.motion,
        force_bias=least,
        speed_stretch=speed_stretch(parameters),
    )
    # On bristles that are stated it is as it should be.
    return fit if points.motion is not None else replace(fit, rest=verdict_of(points.give))


def _alike(forces: Array, errors: Array, share: float) -> Array:
    """Standard errors of events with a common part, which their number does not reduce.

    A ``share`` of each force belongs to that part.
    """
    number = np.where(forces > 0.0, np.sum(forces > 0.0), np.sum(forces < 0.0))
    common = np.hypot(EVENT_ACCURACY, share * forces)
    return np.asarray(np.hypot(errors, common * np.sqrt(number)))


def bias_force(parameters: RigParameters) -> float:
    """Force in N by which a bias of the pressure sensors moves F_s and F_c, in 98 of 100 cases."""
    bias = parameters.number("sensors.pressure_bias") * PRESSURE_RANGE
    return piston_area(parameters) * BIAS_DIFFERENCE * bias


def bias_note() -> str:
    """Say in a line what a bias within the data sheet does to identified friction."""
    sheet = RigParameters(DATA_SHEET)
    bias = sheet.number("sensors.pressure_bias") * PRESSURE_RANGE
    return (
        f"friction holds the bias of the pressure sensors, by data sheet ±{bias * 1e-3:g} kPa each "
        f"or {bias_force(sheet):.1f} N; compare over its intervals (docs/identification.md)"
    )


def speed_stretch(parameters: RigParameters) -> float:
    """Largest relative error of a speed from a nonlinearity that makes one wave along the range."""
    return 2.0 * math.pi * parameters.number("sensors.position_linearity")
