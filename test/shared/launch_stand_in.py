# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Stands in for launch and launch_ros, which no package index has: reads a launch file, no more.

What a launch file makes of its arguments is the file's own; each Node is turned into the command
line that launch_ros would run.
"""

import logging
import runpy
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]

# Where an executable of lib/rodless_sim starts.
SCRIPTS = ROOT / "scripts"


class Context:
    """Holds the launch configurations."""

    def __init__(self, arguments: dict[str, str]) -> None:
        self.launch_configurations = arguments
        self.is_shutdown = False


class LaunchConfiguration:
    """One argument's value."""

    def __init__(self, name: str, default: str | None = None) -> None:
        self._name, self._default = name, default

    def perform(self, context: Context) -> str:
        """Return it; raises KeyError for one that is not there and has no default."""
        found = context.launch_configurations.get(self._name, self._default)
        if found is None:
            raise KeyError(self._name)
        return found


class EqualsSubstitution:
    """true where both are the same."""

    def __init__(self, left: LaunchConfiguration, right: str) -> None:
        self._left, self._right = left, right

    def perform(self, context: Context) -> str:
        """Compare."""
        return str(self._left.perform(context) == self._right).lower()


class Node:
    """What launch_ros starts: :attr:`command` and what happens at its end."""

    def __init__(
        self,
        *,
        package: str,
        executable: str,
        namespace: str,
        output: str,
        on_exit: Callable[..., Any],
        name: str = "",
        parameters: Iterable[Any] = (),
        arguments: Iterable[str] = (),
        ros_arguments: Iterable[str] = (),
    ) -> None:
        assert output == "screen"
        self.package, self.executable, self.name = package, executable, name
        self.namespace, self.on_exit = namespace, on_exit
        if package != "rodless_sim":
            self.parameters = list(parameters)
            return
        self.parameters = [Path(file) for file in parameters]
        files = [word for file in parameters for word in ("--params-file", str(file))]
        assert namespace.startswith("/")  # any other launch_ros puts below the pushed one
        remapping = [f"__node:={name}"] * bool(name) + [f"__ns:={namespace}"]
        self.command = [
            *(sys.executable, str(SCRIPTS / executable), *arguments, "--ros-args", *ros_arguments),
            *(word for rule in remapping for word in ("-r", rule)),
            *files,
        ]


# Packages of others that are taken to be installed.
INSTALLED: set[str] = set()


def _prefix(package: str) -> str:
    if package not in INSTALLED:
        raise KeyError(package)
    return "/opt/ros"


def _modules() -> dict[str, ModuleType]:
    """Return what launch files import, by name."""
    record = SimpleNamespace
    contents: dict[str, dict[str, Any]] = {
        "ament_index_python": {},
        "ament_index_python.packages": {
            "get_package_share_directory": lambda _: str(ROOT),
            "get_package_prefix": _prefix,
            "PackageNotFoundError": KeyError,
        },
        "launch": {"LaunchContext": Context, "LaunchDescription": list},
        "launch.actions": {
            "DeclareLaunchArgument": lambda name, **of: record(kind="argument", name=name, **of),
            "GroupAction": lambda actions: record(kind="group", actions=actions),
            "IncludeLaunchDescription": lambda source, launch_arguments: record(
                kind="include", source=source, arguments=dict(launch_arguments)
            ),
            "OpaqueFunction": lambda function: record(kind="function", function=function),
            "Shutdown": lambda reason: record(kind="shutdown", reason=reason),
        },
        "launch.events": {},
        "launch.events.process": {"ProcessExited": object},
        "launch.logging": {"get_logger": logging.getLogger},
        "launch.launch_description_sources": {"PythonLaunchDescriptionSource": str},
        "launch.substitutions": {
            "LaunchConfiguration": LaunchConfiguration,
            "EqualsSubstitution": EqualsSubstitution,
        },
        "launch_ros": {},
        "launch_ros.actions": {"Node": Node},
    }
    modules = {}
    for name, content in contents.items():
        modules[name] = ModuleType(name)
        vars(modules[name]).update(content)
    return modules


@contextmanager
def _stand_in() -> Iterator[None]:
    # One by one: patch.dict would take away what was imported meanwhile, too, and whoever imports
    # that again has its classes twice.
    with pytest.MonkeyPatch.context() as patch:
        for name, module in _modules().items():
            patch.setitem(sys.modules, name, module)
        yield


def launch_nodes(file: str, **arguments: str) -> list[Node]:
    """Return the nodes that `ros2 launch rodless_sim FILE NAME:=VALUE` starts.

    Of arguments that are not declared launch says nothing, and hands them on to what is included;
    ``ros_namespace`` is what PushRosNamespace leaves there.
    Raises RuntimeError where launch would end with an error.
    """
    with _stand_in():
        description = runpy.run_path(str(ROOT / "launch" / file))["generate_launch_description"]()
        declared = {action.name: action for action in description if action.kind == "argument"}
        context = Context(dict(arguments))
        for name, action in declared.items():
            default = _performed(action.default_value, context)
            value = context.launch_configurations.setdefault(name, default)
            if action.choices and value not in action.choices:
                raise RuntimeError(f"{name}:={value}: not one of {action.choices}")
        return [node for action in description for node in _visit(action, context)]


def _performed(value: Any, context: Context) -> str:
    """Return the text that a text or a substitution stands for."""
    return value if isinstance(value, str) else str(value.perform(context))


def _visit(action: Any, context: Context) -> list[Node]:
    match action.kind:
        case "function":
            return list(action.function(context) or [])
        case "group":
            return [node for inner in action.actions for node in _visit(inner, context)]
        case "include":
            given = {name: _performed(value, context) for name, value in action.arguments.items()}
            inherited = context.launch_configurations
            return launch_nodes(Path(action.source).name, **{**inherited, **given})
    return []
