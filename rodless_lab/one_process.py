"""Plant and controller in one process, one executor, for machines where two are too many."""

from rodless_base.ros_process import run_nodes
from rodless_base.start import Stop
from rodless_control.controller_node import ControllerNode
from rodless_sim.plant_node import PlantNode


def main(stop: Stop) -> int:
    """Run both until ``stop``."""
    return run_nodes([PlantNode, ControllerNode], stop)
