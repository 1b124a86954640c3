"""ROS parameter files (YAML): find the presets, read one node's section."""

import re
from collections.abc import Collection, Iterator
from pathlib import Path

import yaml


class _Loader(yaml.SafeLoader):
    """Reads numbers as ROS does: ``1e-5`` is one, for YAML 1.1 it is a text."""


_Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float",
    re.compile(r"[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+$"),
    list("-+.0123456789"),
)


def preset_directory() -> Path:
    """Return ``config/`` of the source tree, or its copy inside the installed package."""
    installed = Path(__file__).parent / "config"
    return installed if installed.is_dir() else Path(__file__).parents[1] / "config"


def preset_names() -> list[str]:
    """Return the names of the presets that ship with the package."""
    return sorted(file.stem for file in preset_directory().glob("*.yaml"))


def preset_file(name: str) -> Path:
    """Return the file of preset ``name``; raises FileNotFoundError listing what there is."""
    if name not in preset_names():
        raise FileNotFoundError(f"no preset {name!r}; there are {', '.join(preset_names())}")
    return preset_directory() / f"{name}.yaml"


# The last part of a section's name that stands for every node.
EVERY_NODE = ("*", "**")


def read_parameter_file(
    path: str | Path, node: str, foreign: Collection[str] = ()
) -> dict[str, object]:
    """Return the parameters that the file at ``path`` gives to ``node``, dotted names as keys.

    A section applies when the last part of its name is ``node``, ``*`` or ``**``
    (``plant``, ``/rig/plant``, ``/**/plant``, ``/**``), whatever the namespace before it; later
    sections win. Parameters that every node has are left out, and in sections for every node the
    names ``foreign``, which are for other nodes. Raises ValueError for a file that is not a ROS
    parameter file.
    """
    found: dict[str, object] = {}
    for section, tree in read_sections(path):
        if is_for_every_node(section):
            found |= {name: value for name, value in flattened(tree) if name not in foreign}
        elif section.rsplit("/", 1)[-1] == node:
            found |= flattened(tree)
    return {name: value for name, value in found.items() if not is_of_rclpy(name)}


def is_for_every_node(section: str) -> bool:
    """Whether a section's name stands for every node: ``/**``."""
    return section.rsplit("/", 1)[-1] in EVERY_NODE


def read_sections(path: str | Path) -> list[tuple[str, object]]:
    """Return names and contents of a parameter file's sections; raises ValueError."""
    try:
        document = yaml.load(Path(path).read_text(encoding="utf-8"), _Loader)
    except yaml.YAMLError as error:
        raise ValueError(f"not YAML: {error}") from error
    if not isinstance(document, dict):
        raise ValueError("not a ROS parameter file: no node sections")
    sections = []
    for section, content in document.items():
        if not isinstance(content, dict) or set(content) != {"ros__parameters"}:
            raise ValueError(f"section {section!r} must hold ros__parameters and nothing else")
        sections.append((str(section), content["ros__parameters"] or {}))
    return sections


def is_of_rclpy(name: str) -> bool:
    """Whether ``name`` is a parameter that rclpy itself gives every node."""
    return name in ("use_sim_time", "start_type_description_service") or name.startswith(
        "qos_overrides."
    )


def flattened(tree: object, prefix: str = "") -> Iterator[tuple[str, object]]:
    """Yield dotted names and values of a section's content; raises ValueError."""
    if not isinstance(tree, dict):
        raise ValueError(f"{prefix or 'ros__parameters'}: expected names and values")
    for key, value in tree.items():
        name = f"{prefix}{key}"
        if isinstance(value, dict):
            yield from flattened(value, f"{name}.")
        else:
            yield name, value
