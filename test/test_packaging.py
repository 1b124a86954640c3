# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The package is what ROS tools and pip expect, and the same under both."""

import ast
import email
import os
import re
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from configparser import ConfigParser
from importlib import import_module
from pathlib import Path
from xml.etree import ElementTree

import pytest

from rodless_lab.session.domain import own_domain

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[1]
PRODUCT = ["rodless_base", "rodless_sim", "rodless_control", "rodless_lab", "rodless_pytest"]
PRESETS = {"paper.yaml", "calibrated.yaml"}
EXECUTABLES = {"plant", "controller", "rig", "recorder"}

# How a module that is not ours is called: when imported, on PyPI, by rosdep.
# A name that PyPI does not have comes with ROS alone.
THIRD_PARTY = {
    "numpy": ("numpy", "python3-numpy"),
    "numba": ("numba", "python3-numba"),
    "yaml": ("PyYAML", "python3-yaml"),
    "mcap": ("mcap", None),
    "lz4": ("lz4", None),
    "zstandard": ("zstandard", None),
    "matplotlib": ("matplotlib", "python3-matplotlib"),
    "scipy": ("scipy", "python3-scipy"),
    "pandas": ("pandas", "python3-pandas"),
    "pyarrow": ("pyarrow", None),
    "psutil": ("psutil", "python3-psutil"),
    "casadi": ("casadi", None),
    "sksundae": ("scikit-sundae", None),
    "control": ("control", None),
    "nicegui": ("nicegui", None),
    "fastapi": ("fastapi", None),
    "uvicorn": ("uvicorn", None),
    "playwright": ("playwright", None),
    "SALib": ("SALib", None),
    "distributed": ("distributed", None),
    "gymnasium": ("gymnasium", None),
    "pytest": ("pytest", "python3-pytest"),
    "hypothesis": ("hypothesis", "python3-hypothesis"),
    "rosbags": ("rosbags", None),
    "setuptools": ("setuptools", None),
    "packaging": ("packaging", "python3-packaging"),
    "catkin_pkg": ("catkin_pkg", "python3-catkin-pkg"),
    "ament_copyright": (None, "ament_copyright"),
    "ament_flake8": (None, "ament_flake8"),
    "ament_pep257": (None, "ament_pep257"),
    "rclpy": ("ros-jazzy-rclpy", "rclpy"),
    "std_msgs": ("ros-jazzy-std-msgs", "std_msgs"),
    "sensor_msgs": ("ros-jazzy-sensor-msgs", "sensor_msgs"),
    "std_srvs": ("ros-jazzy-std-srvs", "std_srvs"),
    "diagnostic_msgs": ("ros-jazzy-diagnostic-msgs", "diagnostic_msgs"),
    "rosgraph_msgs": ("ros-jazzy-rosgraph-msgs", "rosgraph_msgs"),
    "builtin_interfaces": ("ros-jazzy-builtin-interfaces", "builtin_interfaces"),
    "rcl_interfaces": ("ros-jazzy-rcl-interfaces", "rcl_interfaces"),
    "trajectory_msgs": ("ros-jazzy-trajectory-msgs", "trajectory_msgs"),
    "ament_index_python": (None, "ament_index_python"),
    "simulation_interfaces": (None, "simulation_interfaces"),
    "launch": (None, "launch"),
    "launch_ros": (None, "launch_ros"),
}


def environment(**variables: str) -> dict[str, str]:
    """Return that of a shell where no ROS is sourced, with these variables on top.

    Coverage is not measured there: what runs is a copy, often of the product's own files.
    """
    inherited = {
        name: value
        for name, value in os.environ.items()
        if name not in ("AMENT_PREFIX_PATH", "ROS_DISTRO") and not name.startswith("COVERAGE_")
    }
    return {**inherited, **variables}


def run(*command: str | Path, cwd: Path, code: int = 0, **variables: str) -> str:
    """Run a command in that environment to the exit code expected, and return what it printed."""
    done = subprocess.run(
        command,
        cwd=cwd,
        env=environment(**variables),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == code, f"{command}:\n{done.stdout}"
    return done.stdout


def copied_tree(destination: Path) -> Path:
    """Copy what is built from, so that building leaves no trace in the checkout."""
    for name in ("package.xml", "setup.py", "pyproject.toml", "LICENSE"):
        destination.mkdir(exist_ok=True)
        shutil.copy(ROOT / name, destination)
    for name in (
        "benchmarks",
        "config",
        "description",
        "launch",
        "resource",
        "scripts",
        "templates",
        *PRODUCT,
    ):
        shutil.copytree(
            ROOT / name, destination / name, ignore=shutil.ignore_patterns("__pycache__")
        )
    return destination


def colcon_build(workspace: Path, *options: str) -> Path:
    """Build a copy of the checkout with colcon and return the package's install prefix."""
    copied_tree(workspace / "src")
    run(
        *(sys.executable, "-m", "colcon", "--log-base", workspace / "log", "build"),
        *("--base-paths", workspace / "src", "--build-base", workspace / "build"),
        *("--install-base", workspace / "install", *options),
        cwd=workspace,
        COLCON_HOME=str(workspace),
    )
    return workspace / "install" / "rodless_sim"


@pytest.fixture(scope="module", params=[(), ("--symlink-install",)], ids=["copies", "symlinks"])
def prefix(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where colcon has installed the package, in both ways that ROS users build."""
    return colcon_build(tmp_path_factory.mktemp("colcon"), *request.param)


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Iterator[zipfile.ZipFile]:
    """The wheel that pip builds and installs."""
    folder = tmp_path_factory.mktemp("pip")
    run(
        *(sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation"),
        *("--wheel-dir", folder, copied_tree(folder / "src")),
        cwd=folder,
    )
    (file,) = folder.glob("*.whl")
    with zipfile.ZipFile(file) as archive:
        yield archive


def metadata(wheel: zipfile.ZipFile, name: str) -> str:
    """Text of one file of the wheel's own description."""
    (path,) = (item for item in wheel.namelist() if item.endswith(f".dist-info/{name}"))
    return wheel.read(path).decode()


def manifest() -> ElementTree.Element:
    """Parsed package.xml."""
    return ElementTree.parse(ROOT / "package.xml").getroot()


def test_colcon_lays_the_executables_where_ros2_run_looks(prefix: Path) -> None:
    """Each node is an executable file of lib/rodless_sim, run by whatever python3 comes first."""
    folder = prefix / "lib" / "rodless_sim"
    assert {file.name for file in folder.iterdir()} == EXECUTABLES
    for name in EXECUTABLES:
        assert os.access(folder / name, os.X_OK), f"{name} is not executable"
        assert (folder / name).read_text().startswith("#!/usr/bin/env python3\n")


def test_colcon_registers_the_package(prefix: Path) -> None:
    """The ament index knows the package; its manifest, presets and launch files are in share."""
    share = prefix / "share"
    assert (share / "ament_index/resource_index/packages/rodless_sim").is_file()
    assert (share / "rodless_sim/package.xml").read_text() == (ROOT / "package.xml").read_text()
    assert {file.name for file in (share / "rodless_sim/config").glob("*.yaml")} == PRESETS
    assert (share / "rodless_sim/config/sensors/data_sheet.yaml").is_file()
    assert (share / "rodless_sim/config/scenarios/leak.yaml").is_file()
    assert (share / "rodless_sim/config/laws/cascade.yaml").is_file()
    assert (share / "rodless_sim/config/rosbag2/lossless.yaml").is_file()
    assert (share / "rodless_sim/launch/rig.launch.py").is_file()
    views = {file.name for file in (share / "rodless_sim/description").iterdir()}
    assert views == {file.name for file in (ROOT / "description").iterdir()}
    assert {"rig.rviz", "foxglove.json", "plotjuggler.xml"} <= views


def in_the_built_workspace(prefix: Path, command: str, code: int = 0) -> str:
    """Run a shell command where the build is sourced, far from the checkout, in a ROS domain."""
    with own_domain() as domain:
        return run(
            *("sh", "-c", f'. "$COLCON_CURRENT_PREFIX/local_setup.sh" && {command}'),
            cwd=prefix,
            code=code,
            COLCON_CURRENT_PREFIX=str(prefix.parent),
            PATH=f"{Path(sys.executable).parent}:{os.environ['PATH']}",
            **domain,
        )


def test_colcon_installs_the_template_folder(prefix: Path) -> None:
    """What a user copies to test a controller of their own is in share, whole."""
    installed = prefix / "share/rodless_sim/templates/controller_test"
    ours = ROOT / "templates" / "controller_test"
    names = {file.name for file in ours.iterdir() if file.is_file()}
    assert {file.name for file in installed.iterdir() if file.is_file()} == names
    controllers = {"example_controller.py", "pressure_controller.py"}
    assert {"README.md", "test_controller.py", *controllers} == names


def test_the_presets_are_found_after_colcon(prefix: Path) -> None:
    """In a shell that has sourced the build, the package finds the presets of that build."""
    script = "from rodless_base.parameter_file import preset_directory; print(preset_directory())"
    found = Path(in_the_built_workspace(prefix, f'python3 -c "{script}"').strip())
    assert found.is_relative_to(prefix.parents[1])
    assert {file.name for file in found.glob("*.yaml")} == PRESETS


@pytest.mark.parametrize("node", ["plant", "controller"])
def test_a_node_starts_from_the_build(prefix: Path, node: str) -> None:
    """The executable reaches the node, which refuses a parameter it does not know."""
    command = f"lib/rodless_sim/{node} --ros-args -p no.such:=1.0"
    assert "no.such: no such parameter" in in_the_built_workspace(prefix, command, code=1)


def test_the_recorder_starts_from_the_build(prefix: Path) -> None:
    """The executable reaches the recorder, which explains itself."""
    assert "usage: " in in_the_built_workspace(prefix, "lib/rodless_sim/recorder --help")


def test_pip_installs_what_colcon_installs(prefix: Path, wheel: zipfile.ZipFile) -> None:
    """Under lib/rodless_sim and share, the wheel has colcon's files, with the same mode."""
    by_pip = {
        item.filename.split(".data/data/")[1]: bool(item.external_attr >> 16 & 0o111)
        for item in wheel.infolist()
        if ".data/data/" in item.filename
    }
    shell_hooks = re.compile(r"share/(colcon-core/|rodless_sim/(hook/|package\.(?!xml)))")
    files = (file for top in ("lib/rodless_sim", "share") for file in (prefix / top).rglob("*"))
    by_colcon = {
        name: os.access(file, os.X_OK)
        for file in files
        if file.is_file() and not shell_hooks.match(name := str(file.relative_to(prefix)))
    }
    assert by_pip == by_colcon


def test_the_wheel_carries_presets_and_types(wheel: zipfile.ZipFile) -> None:
    """A pip installation finds the presets inside the package, and type checkers its types."""
    names = set(wheel.namelist())
    assert {f"rodless_base/config/{preset}" for preset in PRESETS} <= names
    assert "rodless_base/config/sensors/data_sheet.yaml" in names
    assert "rodless_base/config/scenarios/leak.yaml" in names
    assert "rodless_base/config/laws/cascade.yaml" in names
    assert "rodless_lab/benchmark/c/rig.c" in names
    assert {f"{package}/py.typed" for package in PRODUCT} <= names


def test_every_module_is_in_the_wheel(wheel: zipfile.ZipFile) -> None:
    """No module or data file beside one is forgotten."""
    kinds = (".py", ".yaml", ".xml", ".js", ".css", ".typed")
    files = (file for package in PRODUCT for file in (ROOT / package).rglob("*"))
    expected = {str(file.relative_to(ROOT)) for file in files if file.suffix in kinds}
    assert expected <= set(wheel.namelist())


def test_the_shell_command_exists(wheel: zipfile.ZipFile) -> None:
    """`rodless` calls a function that is there."""
    entry_points = ConfigParser()
    entry_points.read_string(metadata(wheel, "entry_points.txt"))
    (target,) = [entry_points["console_scripts"]["rodless"]]
    module, function = target.split(":")
    assert callable(getattr(import_module(module), function))


def test_the_urls_are_those_of_the_manifest(wheel: zipfile.ZipFile) -> None:
    """What pip shows of where the package lives comes from the one place that says so."""
    found = email.message_from_string(metadata(wheel, "METADATA")).get_all("Project-URL", [])
    assert found == [f"{url.get('type')}, {url.text}" for url in manifest().iter("url")]
    assert len(found) == 3


def test_versions_agree(wheel: zipfile.ZipFile) -> None:
    """package.xml, the wheel and the newest released entry of the changelog say one version."""
    version = manifest().findtext("version")
    assert email.message_from_string(metadata(wheel, "METADATA"))["Version"] == version
    changelog = (ROOT / "CHANGELOG.rst").read_text()
    headings = re.findall(r"^(Forthcoming|\d+\.\d+\.\d+)\b.*\n-+$", changelog, re.M)
    assert headings[0] in ("Forthcoming", version)


@pytest.mark.parametrize(
    ("variables", "distribution"),
    [
        ({}, "jazzy"),
        ({"ROS_DISTRO": "kilted"}, "kilted"),
        ({"ROS_DISTRO": "jazzy", "AMENT_PREFIX_PATH": "/opt/ros/jazzy"}, None),
    ],
    ids=["nothing set", "ROS_DISTRO", "sourced"],
)
def test_ros_wheels_are_asked_for_unless_ros_is_sourced(
    tmp_path: Path, variables: dict[str, str], distribution: str | None
) -> None:
    """Wheels of ROS, of the distribution named, are required only where there is no ROS."""
    folder = copied_tree(tmp_path / "src")
    setup = (sys.executable, "setup.py", "--quiet")
    run(*setup, "egg_info", "--egg-base", tmp_path, cwd=folder, **variables)
    text = (tmp_path / "rodless_sim.egg-info" / "requires.txt").read_text()
    found = set(re.findall(r"^ros-(\w+)-", text.partition("\n[")[0], re.M))
    assert found == ({distribution} if distribution else set())


def imports(file: Path) -> set[str]:
    """Names of the top-level modules that a file imports, other than Python's and ours."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.add(node.module)
    return {name.split(".")[0] for name in names} - sys.stdlib_module_names - set(PRODUCT)


def imported_by(*places: str) -> set[str]:
    """What the Python files below these folders import."""
    files = [file for place in places for file in (ROOT / place).rglob("*.py")]
    return set().union(*map(imports, files))


def rosdep_keys(*tags: str) -> set[str]:
    """Keys that package.xml declares under these tags."""
    return {str(element.text) for tag in tags for element in manifest().iter(tag)}


def requirements(wheel: zipfile.ZipFile, extra: str | None = None) -> set[str]:
    """Names that setup.py requires always, or for an extra."""
    lines = email.message_from_string(metadata(wheel, "METADATA")).get_all("Requires-Dist", [])
    condition = f'extra == "{extra}"' if extra else ""
    return {
        re.split(r"[^\w-]", line)[0]
        for line in lines
        if line.partition(";")[2].strip().replace("'", '"') == condition
    }


def test_what_the_product_imports_is_what_it_declares(wheel: zipfile.ZipFile) -> None:
    """setup.py and package.xml name every module the product imports, and no other."""
    used = imported_by(*PRODUCT) - {"pytest"}  # loads the plugin, not the other way round
    assert used <= set(THIRD_PARTY)
    names = ("bags", "bench", "control", "dask", "data", "gym", "sensitivity", "view")
    extras = [requirements(wheel, extra) for extra in names]
    required = requirements(wheel).union(*extras)
    assert {THIRD_PARTY[name][0] for name in used} - {None} == required
    declared = rosdep_keys("depend", "exec_depend")
    used |= imported_by("launch")
    needed = {THIRD_PARTY[name][1] for name in used} - {None}
    assert needed | {"ros2launch"} == declared  # a command: nothing imports it


def test_what_the_tests_import_is_declared(wheel: zipfile.ZipFile) -> None:
    """So are the modules that only tests import."""
    used = imported_by("test") - {file.stem for file in (ROOT / "test").rglob("*.py")}
    assert used <= set(THIRD_PARTY)
    required = requirements(wheel) | requirements(wheel, "test")
    assert {THIRD_PARTY[name][0] for name in used} - {None} <= required
    declared = rosdep_keys("depend", "exec_depend", "test_depend")
    assert {THIRD_PARTY[name][1] for name in used} - {None} <= declared
