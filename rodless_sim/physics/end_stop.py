# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The end caps: rigid stops at both ends of the stroke, from which the carriage rebounds.

A cap is far stiffer than anything else on the rig. A spring in its place would need a stiffness
that nobody knows, and would let a large piston push past the stroke until it has eaten the dead
volume behind it. What matters is how much speed a cap leaves. The instant of contact is therefore
located as an event, the velocity v becomes −e v there, and while the carriage rests on a cap any
push into it is held. No state leaves the stroke, and no rebound gains energy.

The default e is that of a hard elastomer pad, a spring k of 2·10⁵ N/m and a damper c of 300 N·s/m
under 1 kg: its damping ratio is ζ = c/(2√(k m)) = 0.335, and half a period of the contact leaves
e = exp(−π ζ/√(1 − ζ²)) = 0.33 of the speed.
"""

from typing import NamedTuple

from rodless_base.kernels import kernel
from rodless_base.parameters import Parameter, ParameterSet, declare
from rodless_sim.physics.sources import JUDGEMENT

PARAMETERS = declare(
    Parameter(
        "end_stop.restitution",
        0.33,
        "",
        "share e of its speed that the carriage keeps when it strikes an end cap",
        f"{JUDGEMENT}: elastomer pad, damping ratio 0.335",
        0.0,
        1.0,
    ),
)

# A rebound slower than this comes to rest on the cap, or a carriage pressed against it would bounce
# for ever. Under the smallest of pushes, 1 N on 1 kg, it would rise by half a nanometre.
SLOWEST_REBOUND = 3e-5  # m/s


class EndStop(NamedTuple):
    """Constants of both end caps."""

    restitution: float  # -

    @classmethod
    def of(cls, parameters: ParameterSet) -> "EndStop":
        """Return the constants for ``parameters``."""
        return cls(parameters.number("end_stop.restitution"))


@kernel
def rebound(end_stop: EndStop, velocity: float) -> float:
    """Velocity in m/s after striking a cap at ``velocity``; 0 where it comes to rest there."""
    after = -end_stop.restitution * velocity
    return after if abs(after) > SLOWEST_REBOUND else 0.0
