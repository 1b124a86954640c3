# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Build and install rodless_sim, the same files under pip and under colcon."""

import os
from pathlib import Path
from xml.etree import ElementTree

from setuptools import find_packages, setup

# What describes the package stands in package.xml.
MANIFEST = ElementTree.parse(Path(__file__).resolve().with_name("package.xml")).getroot()
NAME = MANIFEST.findtext("name")

# The lower bounds are what Ubuntu 24.04 has, whose packages a release installs, or the oldest that
# passes: `make test-lowest` runs the tests with them.
REQUIREMENTS = [
    "numpy>=1.26",  # traces are arrays
    "scipy>=1.11",  # solves for the settled chambers
    "numba>=0.58,<0.69",  # compiles the rig and the laws; a newer one may keep its cache otherwise
    "PyYAML>=6",  # parameter files
    "mcap>=1.1",  # rosbag2's storage format, written without rosbag2,
    "lz4>=4",  # and its compressions, which mcap needs too
    "zstandard>=0.19",
    "matplotlib>=3.6",  # pictures of runs
]

DOCS_REQUIREMENTS = [
    "sphinx>=7.3",
    "myst-nb>=1.1",  # pages in Markdown; runs the notebooks and shows what comes out
    "furo>=2024.8.6",  # the theme
    "sphinxcontrib-mermaid>=1",  # diagrams written as text
    "mermaidx>=0.10",  # draws those, without Node.js and a browser
    "sphinx-copybutton>=0.5",
]

TEST_REQUIREMENTS = [
    "pytest>=9.0",  # ends a test that hangs in compiled code (faulthandler_exit_on_timeout)
    "pytest-cov",
    "pytest-xdist>=3.7",  # tests use every core, files of slow ones first (--no-loadscope-reorder)
    "pytest-rerunfailures>=16.3",  # a crowded machine may keep two processes apart for minutes
    "coverage>=7.10",  # measures the nodes, which are processes of their own
    "hypothesis",  # draws rigs from all declared ranges at once
    "rosbags>=0.10.11",  # an independent reader of the bags
    "pandas",  # runs as data frames,
    "pyarrow",  # and as Parquet
    "psutil",  # the benchmark's arithmetic is tested, which imports it
    "control",  # takes linear models over
    "SALib",  # sensitivities of sweeps
    "distributed",  # sweeps on a cluster
    "gymnasium",  # the rig as its environment,
    "cmaes",  # and what learns a law in it, in an example
    "packaging",  # reads the lock file as pip does
    "nicegui>=3.10",  # the pages of `rodless view`,
    "websockets>=15",  # what sends them nonsense,
    "playwright",  # and what uses them in a Chromium that the machine has
    "catkin_pkg",  # reads the changelog as catkin_prepare_release does
    "colcon-common-extensions",  # the packaging test builds with colcon,
    "setuptools>=70.1",  # and a wheel, which older ones cannot do by themselves
    # A new release of a linter finds new faults; it must not fail a build that passed.
    "ruff==0.17.*",
    "mypy==2.4.*",
    "types-PyYAML",
    "types-psutil",
    "scipy-stubs",
    "pandas-stubs",
]


def ros_requirements() -> list[str]:
    """Name the ROS wheels on PyPI, unless a ROS distribution is sourced: that has its own."""
    if os.environ.get("AMENT_PREFIX_PATH"):
        return []
    distribution = os.environ.get("ROS_DISTRO") or "jazzy"
    return [
        f"ros-{distribution}-{package}"
        for package in (
            "rclpy[fastrtps]",
            "std-msgs",
            "sensor-msgs",
            "std-srvs",
            "diagnostic-msgs",
            "rosgraph-msgs",
            "builtin-interfaces",
            "rcl-interfaces",
            "trajectory-msgs",
        )
    ]


def files(pattern: str) -> list[str]:
    """Return the files that match, as setuptools wants them: relative to the build's folder."""
    return [str(file) for file in sorted(Path().glob(pattern))]


setup(
    name=NAME,
    version="0.1.0",  # as in package.xml: catkin_prepare_release wants to find and change both
    description=" ".join(MANIFEST.findtext("description").split()),
    maintainer=MANIFEST.findtext("maintainer"),
    maintainer_email=MANIFEST.find("maintainer").get("email"),
    license=MANIFEST.findtext("license"),
    project_urls={url.get("type"): url.text for url in MANIFEST.iterfind("url")},
    python_requires=">=3.10",
    packages=[
        *find_packages(include=["rodless_*"]),
        "rodless_base.config",
        "rodless_base.config.laws",
        "rodless_base.config.sensors",
        "rodless_base.config.scenarios",
        "rodless_base.config.studies",
        "rodless_base.config.tasks",
        "rodless_lab.benchmark.c",
    ],
    # An installed package carries the presets inside, so that they are found without ROS, and the
    # C file of the benchmark.
    package_dir={"rodless_base.config": "config", "rodless_lab.benchmark.c": "benchmarks"},
    package_data={
        "": ["*.yaml", "*.xml", "*.c", "*.js", "*.css", "py.typed"],
        "rodless_lab.view": ["static/*.js"],  # a folder of no Python
    },
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        (f"share/{NAME}/benchmarks", files("benchmarks/*.c")),
        (f"share/{NAME}/config", files("config/*.yaml")),
        (f"share/{NAME}/config/laws", files("config/laws/*.yaml")),
        (f"share/{NAME}/config/sensors", files("config/sensors/*.yaml")),
        (f"share/{NAME}/config/scenarios", files("config/scenarios/*.yaml")),
        (f"share/{NAME}/config/studies", files("config/studies/*.yaml")),
        (f"share/{NAME}/config/tasks", files("config/tasks/*.yaml")),
        (f"share/{NAME}/config/rosbag2", files("config/rosbag2/*.yaml")),
        (f"share/{NAME}/config/sros2", files("config/sros2/*.xml")),
        (f"share/{NAME}/launch", files("launch/*.launch.py")),
        (f"share/{NAME}/description", files("description/*")),
        (f"share/{NAME}/templates/controller_test", files("templates/controller_test/*")),
        # Where `ros2 run` looks; pip puts the scripts of entry_points elsewhere.
        (f"lib/{NAME}", ["scripts/plant", "scripts/controller", "scripts/rig", "scripts/recorder"]),
    ],
    entry_points={
        "console_scripts": ["rodless = rodless_lab.cli.entry:main"],
        # Named like the module, so that `pytest -p rodless_pytest` does not load it twice.
        "pytest11": ["rodless_pytest = rodless_pytest"],
    },
    install_requires=REQUIREMENTS + ros_requirements(),
    extras_require={
        "test": TEST_REQUIREMENTS + DOCS_REQUIREMENTS,  # a test builds the site
        "docs": DOCS_REQUIREMENTS,  # make docs
        "mutation": ["cosmic-ray", "tomli; python_version < '3.11'"],  # make mutation
        "data": [
            "pandas>=2.1",
            "pyarrow>=14",
        ],  # runs as data frames and as Parquet; CSV needs neither
        "bags": [],  # read SQLite; Python's own sqlite3 does that now
        "sensitivity": ["SALib>=1.5"],  # which parameter of a sweep matters how much
        "dask": ["distributed>=2023.5"],  # sweeps on a cluster
        "gym": ["gymnasium>=1.0"],  # the rig as an environment for learning
        "control": ["control>=0.10.2"],  # linear models with the methods of python-control
        "bench": [
            "psutil>=5.9",  # reads the processor time of the nodes
            "scikit-sundae>=1.0",  # CVODE, to compare with
            "casadi>=3.6",  # CVODES, to compare with
        ],
        "view": [
            "nicegui>=3.10",  # the pages of `rodless view`, and all they load;
            "fastapi>=0.109",  # what it is made of, for a server
            "uvicorn>=0.22",  # that ends with the verb
        ],
        "supply": [
            "uv",  # locks, and installs the oldest dependencies,
            "pip-audit",  # looks up known vulnerabilities
            "cyclonedx-bom",  # writes the bill of materials
        ],
    },
)
