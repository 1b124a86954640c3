"""Plant and controller in one process, one executor, for machines where two are too many."""

from rodless_base.ros.process import run_nodes
from rodless_base.start import Stop
from rodless_control.node import controller_node
from rodless_lab.session.network import leave_out_own_endpoints
from rodless_sim.node import plant_node


def main(stop: Stop) -> int:
    """Run both until ``stop``."""
    leave_out_own_endpoints()
    plant_node.load()
    controller_node.load()
    return run_nodes([plant_node.PlantNode, controller_node.ControllerNode], stop)
