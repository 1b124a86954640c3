"""The standard simulation_interfaces services: there where the package is, else no trace."""

from importlib.util import find_spec

from node_process import StartNode
from observer import Observer

NAMES = (
    "get_simulator_features",
    "get_simulation_state",
    "set_simulation_state",
    "step_simulation",
    "reset_simulation",
)


def test_services_are_offered_where_the_package_is_installed(
    start_node: StartNode, observer: Observer
) -> None:
    """All five are there or none is, as the package is; the plant says nothing of it either way."""
    with start_node("plant") as plant:
        observer.until(
            lambda: "/plant/reset" in dict(observer.node.get_service_names_and_types()),
            "the plant's services",
        )
        offered = {name for name, _ in observer.node.get_service_names_and_types()}
        there = {name for name in NAMES if f"/plant/{name}" in offered}
        assert there == (set(NAMES) if find_spec("simulation_interfaces") else set())
        assert "simulation_interfaces" not in plant.output
