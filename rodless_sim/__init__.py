"""The plant: a pneumatic servo rig's physics, free of ROS, and one ROS node around it."""

from rodless_base.parameters import ParameterError
from rodless_sim.parameters import RigParameters
from rodless_sim.physics.faults import SimulationError
from rodless_sim.physics.state import HeatedState, State
from rodless_sim.rig import Rig, simulate
from rodless_sim.trace import Trace

__all__ = [
    "HeatedState",
    "ParameterError",
    "Rig",
    "RigParameters",
    "SimulationError",
    "State",
    "Trace",
    "simulate",
]


def __dir__() -> list[str]:
    return __all__
