"""ROS parameter files (YAML): find the presets, read one node's section."""

import re
from collections.abc import Callable, Iterator
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


def read_parameter_file(
    path: str | Path, node: str, foreign: Callable[[str], bool] = lambda _name: False
) -> dict[str, object]:
    """Return the parameters that the file at ``path`` gives to ``node``, dotted names as keys.

    A section applies when the last part of its name is ``node``, ``*`` or ``**``
    (``plant``, ``/rig/plant``, ``/**/plant``, ``/**``), whatever the namespace before it; later
    sections win. Parameters that every node has are left out, and so are those of a section for
    all nodes that are ``foreign``: another node's. Raises ValueError for a file that is not a ROS
    parameter file.
    """
    try:
        document = yaml.load(Path(path).read_text(encoding="utf-8"), _Loader)
    except yaml.YAMLError as error:
        raise ValueError(f"not YAML: {error}") from error
    if not isinstance(document, dict):
        raise ValueError("not a ROS parameter file: no node sections")
    found: dict[str, object] = {}
    for section, content in document.items():
        if not isinstance(content, dict) or set(content) != {"ros__parameters"}:
            raise ValueError(f"section {section!r} must hold ros__parameters and nothing else")
        values = _flattened(content["ros__parameters"] or {}, "")
        addressee = _addressee(section)
        if addressee == node:
            found.update(values)
        elif addressee in ("*", "**"):
            found.update((name, value) for name, value in values if not foreign(name))
    return {name: value for name, value in found.items() if not is_of_rclpy(name)}


def sections_for(path: str | Path, node: str) -> list[str]:
    """Return the names of the sections that address ``node`` by name; [] where it cannot be read.

    ROS itself has refused such a file by then.
    """
    try:
        document = yaml.load(Path(path).read_text(encoding="utf-8"), _Loader)
    except (OSError, yaml.YAMLError):
        return []
    names = document if isinstance(document, dict) else ()
    return [str(section) for section in names if _addressee(section) == node]


def _addressee(section: object) -> str:
    """Return the node that a section is for, whatever the namespace before it."""
    return str(section).rsplit("/", 1)[-1]


def number_meant(text: str) -> object:
    """Return the number, or the list of numbers, that ``text`` is for ROS; others as they are.

    `ros2 param` reads values as YAML 1.1, for which 1e-05 is a text, and a list with one such
    number is one text.

    Examples
    --------
    >>> number_meant("1e-05"), number_meant("[2e-06, 0.5]"), number_meant("high")
    (1e-05, [2e-06, 0.5], 'high')
    """
    try:
        value = yaml.load(text, _Loader)
    except yaml.YAMLError:
        return text
    numbers = value if isinstance(value, list) else [value]
    return value if all(type(number) in (int, float) for number in numbers) else text


def is_of_rclpy(name: str) -> bool:
    """Whether ``name`` is a parameter that rclpy itself gives every node."""
    return name in ("use_sim_time", "start_type_description_service") or name.startswith(
        "qos_overrides."
    )


def _flattened(tree: object, prefix: str) -> Iterator[tuple[str, object]]:
    if not isinstance(tree, dict):
        raise ValueError(f"{prefix or 'ros__parameters'}: expected names and values")
    for key, value in tree.items():
        name = f"{prefix}{key}"
        if isinstance(value, dict):
            yield from _flattened(value, f"{name}.")
        else:
            yield name, value
