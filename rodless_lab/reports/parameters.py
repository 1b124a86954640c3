# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The parameter tables of the docs, from the declarations."""

from collections.abc import Mapping

from rodless_base.columns import quantities
from rodless_base.parameters import Parameter, ParameterSet, Value
from rodless_control import ControllerParameters
from rodless_control.controller_parameters import DEFAULT_LAW
from rodless_control.laws import LAWS, law_class
from rodless_sim import RigParameters
from rodless_sim.physics.state import FURTHER, HeatedMotion, Motion, state_with

INTRODUCTION = """# Parameters

Every parameter of both nodes, and the state of the plant; this page is written from their
declarations by `rodless docs`. The plant's parameters are declared beside the equations that use
them, in the modules of `rodless_sim/physics` and `rodless_sim/instruments`, in
`rodless_sim/faults.py`, `rodless_sim/timing.py` and `rodless_sim/node/command.py`; those of the
controller, here with the law `pid`, in `rodless_control`; the state in
`rodless_sim/physics/state.py`. The names are the same in Python
(`RigParameters().with_values({"supply.pressure": 0.6e6})`), in parameter files
(`config/*.yaml`) and in ROS (`ros2 param set /plant supply.pressure 600000.0`). Values are SI,
pressures absolute. Ranges are inclusive. Parameters marked *fixed* are read when the node starts;
all others may change while it runs. A change is refused as a whole, with a message that names the
value, when any value is bad, unknown, or contradicts another; to change several that depend on each
other use the `set_parameters_atomically` service.

The defaults are the `paper` preset. `calibrated` differs where the last column says so.

## Parameter files

A section is for the node that its name ends with, in the namespace before it; `*` and `**` stand
for any. Namespaces may be nested. These are sections for the plant:

```yaml
plant: {ros__parameters: {supply.pressure: 600000.0}}           # in every namespace
/**/plant: {ros__parameters: {supply.pressure: 600000.0}}       # the same; to ROS, too
/**: {ros__parameters: {supply.pressure: 600000.0}}             # each node takes its own of it
/left/plant: {ros__parameters: {supply.pressure: 600000.0}}     # the plant of the rig left
left: {plant: {ros__parameters: {supply.pressure: 500000.0}}}   # so too; the last that applies wins
```

ROS itself takes `plant:` for the root namespace alone: write `/**/plant:` where nodes get the file
by `--params-file`. A file that has nothing for the plant or controller of a rig is refused, as is a
name that stands twice, and an alias (`*name`). `rodless replay` and `identify` take what is for the
rig in `--namespace`; studies and Python, which have none, refuse a file with sections for the same
node of several rigs.
"""

HEADER = """| name | default | unit | range | meaning | source | calibrated |
|---|---|---|---|---|---|---|
"""

LAWS_INTRODUCTION = """
## Other laws

With another `controller.law` the controller has that law's parameters in place of those of `pid`.
Files may tune several laws: the node leaves out what belongs to the others.
"""

STATE = """
## State

What is known of the plant at one instant: fields of `State`, columns of `Trace`. Of these the plant
integrates {integrated}. Where `chambers.thermodynamics` is `energy_balance` it integrates
{further} too, and the state is a `HeatedState`. With
`valve.dynamics`, `valve.hysteresis` or `valve.dead_time` there is `spool_voltage`, with
`friction.dynamics` what has `bristle` in it, with `friction.drift` what ends in `drift`, with
`coupling.kind` what begins with `piston`, and `coupled`. Other rigs do not have these.

| name | unit | meaning |
|---|---|---|
"""


# The state of a rig with every option.
EVERYTHING = state_with(tuple(FURTHER))


def parameter_reference() -> str:
    """Return the reference page as Markdown."""
    tables = (_table("plant", RigParameters), _table("controller", ControllerParameters))
    return INTRODUCTION + "".join(tables) + _laws() + _state()


def _laws() -> str:
    """The parameters that the other laws of the package bring in place of those of the PID."""
    others = {name: law_class(name).PARAMETERS for name in LAWS if name != DEFAULT_LAW}
    return LAWS_INTRODUCTION + "".join(
        f"\n### {name}\n\n{_law(name, own)}\n" for name, own in others.items()
    )


def _law(name: str, own: Mapping[str, Parameter]) -> str:
    """One law's table; the parameters of laws that it is made of stand in theirs."""
    parts = [law for law in LAWS if law != name and law_class(law).PARAMETERS.keys() <= own.keys()]
    inherited = {parameter for law in parts for parameter in law_class(law).PARAMETERS}
    rest = {parameter: value for parameter, value in own.items() if parameter not in inherited}
    table = HEADER + "\n".join(_rows(ControllerParameters.for_law(name), rest))
    if not parts:
        return table
    named = " and ".join(f"`{law}`" for law in parts)
    return f"With those of {named}:\n\n{table}"


def _state() -> str:
    """What a state, a trace and a record of the plant hold, from the one list of it."""
    rows = [f"| `{name}` | {unit} | {meaning} |" for name, unit, meaning in quantities(EVERYTHING)]
    everywhere, all_of_them = len(Motion._fields), [f"`{name}`" for name in HeatedMotion._fields]
    text = STATE.format(
        integrated=", ".join(all_of_them[:everywhere]),
        further=" and ".join(all_of_them[everywhere:]),
    )
    return text + "\n".join(rows) + "\n"


def _table(node: str, kind: type[ParameterSet]) -> str:
    return f"\n## {node}\n\n{HEADER}" + "\n".join(_rows(kind, kind.DECLARATIONS)) + "\n"


def _rows(kind: type[ParameterSet], declared: Mapping[str, Parameter]) -> list[str]:
    calibrated = kind.preset("calibrated")
    return [_row(parameter, calibrated[name]) for name, parameter in declared.items()]


def _row(parameter: Parameter, calibrated: Value) -> str:
    meaning = parameter.meaning + (" *(fixed)*" if parameter.fixed else "")
    differs = _shown(calibrated) if calibrated != parameter.default else ""
    cells = (
        f"`{parameter.name}`",
        _shown(parameter.default),
        parameter.unit,
        _range(parameter),
        meaning,
        parameter.source,
        differs,
    )
    return "| " + " | ".join(cells) + " |"


def _shown(value: Value) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        return ", ".join(_shown(item) for item in value)
    return f"{value:.7g}" if isinstance(value, float) else str(value)


def _range(parameter: Parameter) -> str:
    if parameter.choices:
        return ", ".join(parameter.choices)
    if isinstance(parameter.default, bool | str):
        return ""
    return f"{parameter.minimum:g} to {parameter.maximum:g}"
