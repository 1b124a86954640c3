# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Who may import whom: the packages' arrows run one way, and ROS stays in its shells."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

from rodless_lab.cli.main import VERBS

ROOT = Path(__file__).parents[1]

# For each package, those of the product it may stand on.
MAY_IMPORT = {
    "rodless_base": set(),
    "rodless_sim": {"rodless_base"},
    "rodless_control": {"rodless_base"},
    "rodless_lab": {"rodless_base", "rodless_sim", "rodless_control"},
    "rodless_pytest": {"rodless_lab"},
}

ROS = ("rclpy", "ament_index_python", "builtin_interfaces", "rcl_interfaces", "std_srvs")


def imported(source: str) -> set[str]:
    """Top-level names of all modules that ``source`` imports, wherever in the file."""
    names = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            names.add(node.module if node.level == 0 else f"relative import of {node.module}")
    return {name.split(".")[0] for name in names}


def is_ros(module: str) -> bool:
    """Whether ``module`` is rclpy or carries ROS interfaces."""
    return module in ROS or module.endswith(("_msgs", "_interfaces"))


def is_shell(path: Path) -> bool:
    """Whether the file's place says that it may import ROS."""
    return (
        bool({"ros", "node"} & set(path.parts))
        or path.stem.endswith("_node")
        or path.parent == ROOT / "rodless_lab" / "session"
    )


# Outside the shells: messages of a bag become objects of their ROS type.
MAY_DESERIALISE = ROOT / "rodless_lab" / "bags" / "reader.py"


def test_imports_are_seen_wherever_they_stand() -> None:
    """The reader of imports finds them inside functions and conditions, and dotted ones."""
    source = "import a.b\nif x:\n    from c.d import e\ndef f():\n    import g, h as i\n"
    assert imported(source) == {"a", "c", "g", "h"}


@pytest.mark.parametrize("package", MAY_IMPORT)
def test_arrows_run_one_way(package: str) -> None:
    """A package imports, of the product, only itself and those below it, by absolute names."""
    allowed = MAY_IMPORT[package] | {package}
    files = sorted((ROOT / package).rglob("*.py"))
    assert files, f"{package} has no files"
    wrong = {
        str(file.relative_to(ROOT)): sorted(strangers)
        for file in files
        if (
            strangers := {
                name
                for name in imported(file.read_text(encoding="utf-8"))
                if name.startswith(("rodless_", "relative "))
            }
            - allowed
        )
    }
    assert not wrong


@pytest.mark.parametrize("package", [name for name in MAY_IMPORT if name != "rodless_pytest"])
def test_ros_stays_in_its_shells(package: str) -> None:
    """Only nodes, message conversion and the session import rclpy or ROS interfaces."""
    wrong = {
        str(file.relative_to(ROOT)): sorted(ros)
        for file in sorted((ROOT / package).rglob("*.py"))
        if not is_shell(file)
        and (ros := set(filter(is_ros, imported(file.read_text(encoding="utf-8")))))
    }
    reader = str(MAY_DESERIALISE.relative_to(ROOT))
    assert wrong == ({reader: ["rclpy"]} if package == "rodless_lab" else {})


def test_a_command_never_imports_another_command() -> None:
    """What two verbs need stands elsewhere; main alone names them, in its table."""
    commands = {module for module, _ in VERBS.values()}
    assert len(commands) > 10
    wrong = {}
    for command in commands:
        source = (ROOT / command.replace(".", "/")).with_suffix(".py").read_text(encoding="utf-8")
        modules = {
            node.module
            for node in ast.walk(ast.parse(source))
            if isinstance(node, ast.ImportFrom) and node.module
        }
        if others := modules & (commands | {"rodless_lab.cli"}):
            wrong[command] = sorted(others)
    assert not wrong


def test_everything_but_the_nodes_loads_without_ros() -> None:
    """Where there is no rclpy at all, rig, controller and closed loop still import."""
    script = (
        "import sys\n"
        "sys.modules['rclpy'] = None\n"
        "from rodless_sim import Rig\n"
        "from rodless_control import Pid\n"
        "from rodless_lab import closed_loop\n"
    )
    run = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=120, check=False
    )
    assert run.returncode == 0, run.stderr


@pytest.mark.ros
@pytest.mark.parametrize(
    ("modules", "left_out"),
    [
        ("rodless_lab.session.status, rodless_lab.session.services", "numba"),
        ("rodless_sim.node.plant_node, rodless_control.node.controller_node", "scipy.optimize"),
    ],
)
def test_what_takes_long_to_load_is_left_out_where_nothing_needs_it(
    modules: str, left_out: str
) -> None:
    """Verbs that ask a rig load no compiler, nodes no optimizer: either is half their start."""
    code = f"import sys, {modules}; sys.exit({left_out!r} in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
