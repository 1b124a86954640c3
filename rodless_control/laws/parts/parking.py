# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Parking: leave the carriage alone once it is there, so that noise does not move the valve.

The slow error e_s is the error e behind a low-pass of ``parking_bandwidth``. Parked or not is an
automaton with hysteresis, for a reference at rest:

    park   when |e_s| < error,  |e| < 8·error  and  |v̂| < 10 mm/s
    leave  when |e_s| ≥ hysteresis·error  or the reference moves

Parked, 1 % of the law acts and its integral holds: friction holds the carriage, and a valve that is
nearly closed keeps the pressures. A relay with hysteresis around a dead band is the usual cure for
hunting under stiction: Olsson and Åström, "Friction generated limit cycles", *IEEE Transactions on
Control Systems Technology* 9(4), 2001, 629-636. An ``error`` of 0 never parks.

A parked carriage may creep: gas that warms or cools changes the force, and seals give way before
they slip. Where the law has a ``correction`` (V/m), it holds the carriage at the edge of the band,

    w = correction·(e_s − min(max(e_s, −error), error))

with a parked e_s that is slower, ``CREEP`` times the bandwidth, so that noise neither moves the
valve nor ends the parking. What a slow e_s would miss, a carriage that breaks loose, leaves by

    leave  when |e − e_s| ≥ 3·error
"""

import math
from typing import NamedTuple

from rodless_base.kernels import kernel
from rodless_base.parameters import Parameter, ParameterSet, declare
from rodless_control.laws.parts.saturation import within

# The share of the law that acts while parked.
PARKED_SHARE = 0.01

# Still on its way: an error this many times the one to park at, or a velocity (m/s) like this.
NEAR = 8.0
SLOW = 0.01

# A parked carriage that is corrected: the slow error's bandwidth as a share of the one before, and
# the error beside the slow one, as a multiple of the one to park at, that is no creep any more.
CREEP = 0.3
LOOSE = 3.0


class ParkingLimits(NamedTuple):
    """Constants of the automaton."""

    error: float  # m
    hysteresis: float
    bandwidth: float  # rad/s
    correction: float = 0.0  # V/m, 0 for none

    @classmethod
    def of(cls, parameters: ParameterSet, law: str, correction: float = 0.0) -> "ParkingLimits":
        """Return the constants that ``law`` is given by ``parameters``, and its ``correction``."""
        return cls(
            parameters.number(f"{law}.parking_error"),
            parameters.number(f"{law}.parking_hysteresis"),
            parameters.number(f"{law}.parking_bandwidth"),
            correction,
        )


class Parking(NamedTuple):
    """Where the automaton is."""

    slow_error: float  # m
    parked: float  # 1, or 0


def declared(
    law: str, error: float, hysteresis: float, bandwidth: float, source: str
) -> dict[str, Parameter]:
    """Return the part's parameters as those of ``law``."""
    return declare(
        Parameter(
            f"{law}.parking_error",
            error,
            "m",
            "slow error within which the carriage is left alone, 0 for never",
            source,
            0.0,
            0.01,
        ),
        Parameter(
            f"{law}.parking_hysteresis",
            hysteresis,
            "",
            "slow error at which parking ends, as a multiple of the one at which it begins",
            source,
            1.0,
            100.0,
        ),
        Parameter(
            f"{law}.parking_bandwidth",
            bandwidth,
            "rad/s",
            "bandwidth of the low-pass of the slow error",
            source,
            1.0,
            1e4,
        ),
    )


@kernel
def afoot() -> Parking:
    """State before the first sample: not parked."""
    return Parking(0.0, 0.0)


@kernel
def parked(
    limits: ParkingLimits,
    parking: Parking,
    error: float,
    velocity: float,
    reference_velocity: float,
    interval: float,
) -> Parking:
    """State after ``interval`` s with ``error`` (m) and estimated ``velocity`` (m/s)."""
    if limits.error <= 0.0:
        return Parking(error, 0.0)  # from which a slow error goes on, once it is to park
    if interval <= 0.0:
        return parking
    creeping = parking.parked > 0.0 and limits.correction > 0.0
    bandwidth = CREEP * limits.bandwidth if creeping else limits.bandwidth
    share = -math.expm1(-bandwidth * interval)
    slow_error = parking.slow_error + share * (error - parking.slow_error)
    if reference_velocity != 0.0:
        stays = False
    elif parking.parked > 0.0:
        loose = creeping and abs(error - slow_error) >= LOOSE * limits.error
        stays = abs(slow_error) < limits.hysteresis * limits.error and not loose
    else:
        near = abs(error) < NEAR * limits.error and abs(velocity) < SLOW
        stays = near and abs(slow_error) < limits.error
    return Parking(slow_error, 1.0 if stays else 0.0)


@kernel
def acting(parking: Parking) -> float:
    """Share of the law that acts."""
    return PARKED_SHARE if parking.parked > 0.0 else 1.0


@kernel
def held(limits: ParkingLimits, parking: Parking) -> float:
    """Effort (V) that holds a parked carriage at the edge of the band; 0 within it."""
    inside = within(parking.slow_error, -limits.error, limits.error)
    return limits.correction * (parking.slow_error - inside)
