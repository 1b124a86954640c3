# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Parameters through the services of the running nodes: described, changed, refused as a whole."""

import math
from collections.abc import Iterator
from pathlib import Path

import pytest
from paused_plant import PausedPlant, positions
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.msg import ParameterType, ParameterValue, SetParametersResult
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.parameter import Parameter
from running import StartProcess, until_it_says
from sensor_msgs.msg import FluidPressure
from std_srvs.srv import Trigger

from rodless_base.parameters import ParameterSet
from rodless_control import ControllerParameters
from rodless_lab.session.errors import RefusedError
from rodless_lab.session.node_process import NodeProcess
from rodless_lab.session.observer import Observer
from rodless_sim import Rig, RigParameters
from rodless_sim.node.plant_node import PlantNode

SETS: dict[str, type[ParameterSet]] = {
    "/plant": RigParameters,
    "/other/controller": ControllerParameters,
}
NODES = pytest.mark.parametrize("node", SETS)

PERIOD = 0.01


@pytest.fixture(scope="module", autouse=True)
def plant(start_node: StartProcess) -> Iterator[NodeProcess]:
    """Run both nodes, in namespaces apart, so that the controller does not command the plant."""
    with (
        start_node("plant", {"time.period": PERIOD, "valve.command_timeout": 60.0}) as process,
        start_node("controller", namespace="other"),
    ):
        yield process


@pytest.fixture(autouse=True)
def unchanged(observer: Observer, plant: NodeProcess) -> Iterator[None]:  # noqa: ARG001
    """Give each test the parameters as they were."""
    before = {node: observer.get_parameters(node, changeable(node)) for node in SETS}
    yield
    for node, values in before.items():
        observer.set_parameters(node, values)


def set_one_by_one(
    observer: Observer, node: str, values: dict[str, float]
) -> list[SetParametersResult]:
    """Set parameters as `ros2 param load` does; return the result of each."""
    client = observer.parameter_client(node)
    parameters = [Parameter(name, value=value) for name, value in values.items()]
    return observer.result(lambda: client.set_parameters(parameters), "an answer").results


def changeable(node: str) -> list[str]:
    """Names of the parameters that may change while the node runs."""
    return [name for name, declared in SETS[node].DECLARATIONS.items() if not declared.fixed]


TYPES = {
    bool: ParameterType.PARAMETER_BOOL,
    int: ParameterType.PARAMETER_INTEGER,
    float: ParameterType.PARAMETER_DOUBLE,
    str: ParameterType.PARAMETER_STRING,
    tuple: ParameterType.PARAMETER_DOUBLE_ARRAY,
}


@NODES
def test_every_parameter_is_declared_and_no_other(observer: Observer, node: str) -> None:
    """The node lists the declared parameters, and besides them only what rclpy gives it."""
    response = observer.result(observer.parameter_client(node).list_parameters, "a list")
    others = set(response.result.names) - set(SETS[node].DECLARATIONS)
    assert set(SETS[node].DECLARATIONS) <= set(response.result.names)
    assert others <= {"use_sim_time", "start_type_description_service"}


@NODES
def test_every_descriptor_tells_meaning_unit_source_and_range(
    observer: Observer, node: str
) -> None:
    """A user of `ros2 param describe` reads there what the declaration says."""
    names = list(SETS[node].DECLARATIONS)
    client = observer.parameter_client(node)
    response = observer.result(lambda: client.describe_parameters(names), "descriptors")
    assert [descriptor.name for descriptor in response.descriptors] == names
    for descriptor in response.descriptors:
        declared = SETS[node].DECLARATIONS[descriptor.name]
        assert descriptor.type == TYPES[type(declared.default)]
        assert descriptor.read_only == declared.fixed
        assert not descriptor.dynamic_typing
        assert declared.meaning in descriptor.description
        assert declared.source in descriptor.description
        assert not declared.unit or f"[{declared.unit}]" in descriptor.description
        bounds = (declared.minimum, declared.maximum)
        if type(declared.default) is int:
            (range_,) = descriptor.integer_range
            assert (range_.from_value, range_.to_value) == bounds
        elif type(declared.default) is float:
            (range_,) = descriptor.floating_point_range
            assert (range_.from_value, range_.to_value) == bounds
            assert all(math.isfinite(bound) for bound in bounds)
        elif type(declared.default) is tuple:
            assert all(f"{bound:g}" in descriptor.additional_constraints for bound in bounds)
        for choice in declared.choices:
            assert choice in descriptor.additional_constraints


@NODES
def test_values_are_the_defaults_until_something_is_said(observer: Observer, node: str) -> None:
    """What no file and no command line names has its declared default."""
    given = {"time.period", "valve.command_timeout"}
    defaults = {
        name: list(value) if isinstance(value, tuple) else value
        for name, value in SETS[node]().items()
        if name not in given
    }
    found = observer.get_parameters(node, defaults)
    assert {
        name: list(value) if hasattr(value, "__len__") and not isinstance(value, str) else value
        for name, value in found.items()
    } == defaults


def test_supply_pressure_takes_effect_while_the_plant_runs(observer: Observer) -> None:
    """A new supply pressure shows on supply/pressure."""
    pressures = observer.collect(FluidPressure, "/supply/pressure")
    observer.set_parameters("/plant", {"supply.pressure": 4e5})
    observer.wait(
        lambda: pressures and pressures[-1].fluid_pressure == pytest.approx(4e5),
        "the new supply pressure",
    )


def test_friction_takes_effect_in_mid_move(observer: Observer) -> None:
    """Friction that changes between two steps acts as on a rig without ROS, to the last digit."""
    plant = PausedPlant(observer)
    plant.reset()
    plant.command(8.0)
    rig = Rig()
    assert positions(plant.steps(10)) == [rig.advance(8.0, PERIOD).position for _ in range(10)]
    change = {"friction.forward.viscous": 1500.0, "friction.form": "saturating"}
    observer.set_parameters("/plant", change)
    rig.configure(RigParameters(change))
    expected = [rig.advance(8.0, PERIOD).position for _ in range(10)]
    assert positions(plant.steps(10)) == expected
    plant.pause(False)


OLD_AREA = [2.0, 0.3, 0.0, 1.5, 0.5, 0.0, 0.1, 1.3, 0.0]
NEW_AREA = [2e-6, 0.3, 0.0, 1.5e-6, 0.5, 0.0, 1e-7, 1.3, 0.0]


@pytest.mark.parametrize(
    ("node", "name", "given", "taken"),
    [
        ("/plant", "supply.pressure", 700_000, 700_000.0),
        ("/plant", "friction.forward.static", 30, 30.0),
        ("/other/controller", "controller.kp", 250, 250.0),
        (
            "/plant",
            "valve.flow_coefficients",
            [1, 0, 0, 0, 0, 0],
            [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        ),
        # As `ros2 param load` and `set` send 1e-05, and a list with such a number in it.
        ("/plant", "friction.capture_velocity", "2e-05", 2e-5),
        ("/plant", "valve.flow_coefficients", "[1.0, 1e-05, 0, 0, 0, 0]", [1.0, 1e-5, *[0.0] * 4]),
        ("/plant", "sensors.seed", "2e0", 2),
        # In mm², as older files have the amplitudes.
        (
            "/plant",
            "valve.area_coefficients",
            [2.0, 0.3, 0.0, 1.5, 0.5, 0.0, 0.1, 1.3, 0.0],
            NEW_AREA,
        ),
    ],
)
def test_a_number_in_another_guise_is_taken(
    observer: Observer, node: str, name: str, given: object, taken: object
) -> None:
    """Without a point, or as the text ROS's tools make of it: the type stays what it was."""
    observer.set_parameters(node, {name: given})
    value = observer.get_parameters(node, [name])[name]
    assert (list(value) if isinstance(taken, list) else value) == taken  # type: ignore[call-overload]
    client = observer.parameter_client(node)
    types = observer.result(lambda: client.get_parameter_types([name]), "types").types
    assert list(types) == [TYPES[type(SETS[node].DECLARATIONS[name].default)]]


REFUSED = [
    ("/plant", "supply.pressure", math.nan, "nan"),
    ("/plant", "supply.pressure", math.inf, "inf"),
    ("/plant", "supply.pressure", -math.inf, "-inf"),
    ("/plant", "supply.pressure", 2e6, "2000000"),
    ("/plant", "supply.pressure", 9e4, "below atmosphere.pressure"),
    ("/plant", "supply.pressure", "high", "'high' refused, must be a number (Pa)"),
    ("/plant", "supply.pressure", True, "must be a number (Pa)"),
    ("/plant", "supply.pressure", None, "must be a number (Pa)"),
    ("/plant", "supply.presure", 6e5, "did you mean supply.pressure?"),
    ("/plant", "no.such.thing.at.all", 1.0, "no such parameter"),
    ("/plant", "cylinder.moving_mass", 0.0, "0.0"),
    ("/plant", "cylinder.locked", 1, "must be true or false"),
    ("/plant", "friction.forward.viscous", -1.0, "-1.0"),
    ("/plant", "friction.forward.static", 5.0, "below friction.forward.coulomb"),
    ("/plant", "friction.reverse.coulomb", 100.0, "friction.reverse.static"),
    ("/plant", "friction.form", "coulomb", "one of stribeck, saturating"),
    ("/plant", "valve.flow_coefficients", [1.0, 2.0], "6 numbers"),
    ("/plant", "valve.flow_coefficients", [math.nan] * 6, "nan"),
    ("/plant", "time.period", 0.02, "read-only"),
    ("/plant", "time.mode", "realtime", "read-only, given when the node starts; it has this value"),
    ("/plant", "time.mode", "lockstep", "it is 'realtime'"),
    ("/plant", "controller.kp", 500.0, "no such parameter of the plant, it is the controller's"),
    ("/plant", "supply.pressure", "[6e5]", "must be a number (Pa)"),
    ("/plant", "supply.pressure", "6e5 Pa", "must be a number (Pa)"),
    ("/plant", "friction.form", "1e-05", "one of stribeck, saturating"),
    ("/plant", "cylinder.locked", "1e0", "must be true or false"),
    ("/other/controller", "friction.form", "stribeck", "it is the plant's"),
    ("/other/controller", "controller.kp", math.nan, "nan"),
    ("/other/controller", "controller.kp", -1.0, "-1.0"),
    ("/other/controller", "controller.kp", "much", "must be a number (V/m)"),
    ("/other/controller", "controller.kpp", 1.0, "did you mean controller.kp?"),
    ("/other/controller", "controller.minimum_voltage", 6.0, "controller.neutral_voltage"),
    ("/other/controller", "reference.type", "steps", "one of setpoint"),
]


@pytest.mark.parametrize(
    ("node", "name", "value", "words"), REFUSED, ids=[f"{n}={v}" for _, n, v, _ in REFUSED]
)
def test_a_bad_value_is_refused_by_name_and_changes_nothing(
    observer: Observer, node: str, name: str, value: object, words: str
) -> None:
    """The answer names the parameter and what is wrong; alone or within a change, nothing changes.

    The change sets a good value too, which must not be taken either.
    """
    good = {"/plant": "atmosphere.temperature", "/other/controller": "reference.velocity"}[node]
    before = observer.get_parameters(node, SETS[node].DECLARATIONS)
    bad = Parameter(name, Parameter.Type.NOT_SET) if value is None else Parameter(name, value=value)
    client = observer.parameter_client(node)
    (alone,) = observer.result(lambda: client.set_parameters([bad]), "an answer").results
    fine = Parameter(good, value=before[good] + 1.0)  # type: ignore[operator]
    both = observer.result(
        lambda: client.set_parameters_atomically([fine, bad]), "an answer"
    ).result
    for result in (alone, both):
        assert not result.successful
        assert words in result.reason
        assert name in result.reason
    assert repr(observer.get_parameters(node, SETS[node].DECLARATIONS)) == repr(before)


@NODES
def test_a_value_of_an_unknown_type_is_refused_and_counted(observer: Observer, node: str) -> None:
    """The node goes on as it was: its own services, its diagnostics and its topics."""
    before = observer.counter(node, "errors in callbacks", fresh=True)
    unknown = ParameterMessage(name="supply.pressure", value=ParameterValue(type=10))
    for service, kind in (
        ("set_parameters", SetParameters),
        ("set_parameters_atomically", SetParametersAtomically),
    ):
        answer = observer.call(kind, f"{node}/{service}", parameters=[unknown])
        (result,) = answer.results if service == "set_parameters" else [answer.result]
        assert not result.successful
        assert result.reason == "supply.pressure: type 10 refused, ParameterType has 0 to 9"
    assert observer.counter(node, "errors in callbacks", fresh=True) == before + 2
    assert observer.call(Trigger, f"{node}/reset").success
    assert "valve closed, reset" not in observer.diagnostic(node, fresh=True).message


def test_a_stroke_that_ends_before_the_carriage_is_refused(observer: Observer) -> None:
    """With the carriage at 58 mm a stroke of 20 mm is refused; back at 0 it is taken."""
    plant = PausedPlant(observer)
    observer.set_parameters("/plant", {"cylinder.initial_position": 0.058})
    assert plant.reset().position[0] == 0.058
    observer.set_parameters("/plant", {"cylinder.initial_position": 0.0})
    with pytest.raises(RefusedError, match=r"cylinder\.stroke: 0\.02 m refused, .* 0\.058 m"):
        observer.set_parameters("/plant", {"supply.pressure": 4e5, "cylinder.stroke": 0.02})
    names = ["supply.pressure", "cylinder.stroke"]
    assert observer.get_parameters("/plant", names) == dict(
        zip(names, (RigParameters()[name] for name in names), strict=True)
    )
    plant.command(5.08)
    assert plant.steps(1)[0].position[0] == 0.058
    plant.reset()
    observer.set_parameters("/plant", {"cylinder.stroke": 0.02})


def test_of_several_changes_one_by_one_the_good_ones_are_taken(observer: Observer) -> None:
    """`ros2 param load` sets one by one: each is judged for itself."""
    change = {"supply.pressure": 5e5, "friction.forward.static": -1.0}
    results = set_one_by_one(observer, "/plant", change)
    assert [result.successful for result in results] == [True, False]
    assert observer.get_parameters("/plant", ["supply.pressure"]) == {"supply.pressure": 5e5}


def test_a_pair_that_only_agrees_as_a_whole_is_taken_as_one_change(observer: Observer) -> None:
    """F_c above the old F_s is refused alone, but not together with a new F_s after it."""
    pair = {"friction.forward.coulomb": 40.0, "friction.forward.static": 50.0}
    with pytest.raises(RefusedError, match=r"friction\.forward\.coulomb"):
        observer.set_parameters("/plant", {"friction.forward.coulomb": 40.0})
    observer.set_parameters("/plant", pair)
    assert observer.get_parameters("/plant", pair) == pair


@NODES
def test_what_rclpy_might_have_but_has_not_is_refused_by_name(
    observer: Observer, node: str
) -> None:
    """The answer of rclpy itself names no parameter."""
    given = Parameter("qos_overrides./joint_states.publisher.depth", value=5)
    for result in set_one_by_one(observer, node, {given.name: given.value}):
        assert not result.successful
        assert result.reason == f"{given.name}: no such parameter"


@NODES
def test_parameters_of_rclpy_itself_stay_its_own(observer: Observer, node: str) -> None:
    """use_sim_time can be changed as on any node."""
    for value in (True, False):
        observer.set_parameters(node, {"use_sim_time": value})
        assert observer.get_parameters(node, ["use_sim_time"]) == {"use_sim_time": value}


def test_what_follows_from_a_change_is_shown_by_the_node_too(
    observer: Observer, plant: NodeProcess
) -> None:
    """With the isentropic index alone the critical ratio changes: it is logged, and can be read."""
    observer.set_parameters("/plant", {"air.isentropic_index": 1.3})
    values = observer.get_parameters("/plant", ["air.isentropic_index", "air.critical_ratio"])
    assert values["air.isentropic_index"] == 1.3
    assert values["air.critical_ratio"] == pytest.approx(0.5457, abs=1e-4)
    until_it_says(plant, "air.isentropic_index: changes also air.critical_ratio 0.545")


def test_a_change_right_after_an_entry_of_a_scenario_is_made(
    observer: Observer, tmp_path: Path
) -> None:
    """Back to what the plant still shows, which has not looked at the scenario since."""
    name = "fault.piston.leak"
    scenario = tmp_path / "leak.yaml"
    scenario.write_text(f"- at: 0.01\n  {name}: 1.0e-9\n")
    given = {"time.mode": "lockstep", "time.period": PERIOD, "time.scenario": str(scenario)}
    overrides = [Parameter(one, value=value) for one, value in given.items()]
    plant = PlantNode(context=observer.context, namespace="/leaking", parameter_overrides=overrides)
    try:
        for _ in range(2):
            plant._engine.step()
        assert plant._engine.rig.parameters[name] == 1e-9
        assert plant.node.get_parameter(name).value == 0.0
        assert plant.node.set_parameters_atomically([Parameter(name, value=0.0)]).successful
        assert plant._engine.rig.parameters[name] == 0.0
        assert plant.node.get_parameter(name).value == 0.0
        plant._poll()
        assert plant.node.get_parameter(name).value == 0.0
    finally:
        plant.close()
