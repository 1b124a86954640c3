"""Sections for every node (``/**``) of a parameter file: which of their names are for whom."""

from contextlib import suppress
from pathlib import Path

import yaml

from rodless_base.parameter_file import (
    flattened,
    is_for_every_node,
    read_parameter_file,
    read_sections,
)
from rodless_base.parameters import ParameterError
from rodless_control import ControllerParameters
from rodless_control.laws import LAWS, law_class
from rodless_sim import RigParameters


def names_of_controller(path: str | Path) -> set[str]:
    """Return the names that the controller has by the file at ``path`` and the plant has not.

    Those of the law that the file names, and of the laws of this package. Raises OSError; a file
    that is no ROS parameter file is left to whoever reads it.
    """
    names = set(ControllerParameters.DECLARATIONS)
    names |= {name for law in LAWS for name in law_class(law).PARAMETERS}
    with suppress(ValueError):
        given = read_parameter_file(path, ControllerParameters.NODE)
        law = str(given.get("controller.law", "pid"))
        names |= ControllerParameters.for_law(law).DECLARATIONS.keys()
    return names - RigParameters.DECLARATIONS.keys()


def divided(path: Path, folder: Path) -> Path:
    """Return a parameter file that gives each node its own names only.

    That is ``path`` itself, or where it has a section for every node, a copy in ``folder`` with one
    for each of plant and controller instead. A name that neither has stays with the plant, which
    refuses it. Raises ParameterError for a file that is no ROS parameter file.
    """
    controllers = names_of_controller(path)
    try:
        sections = read_sections(path)
    except ValueError as error:
        raise ParameterError(f"{path}: {error}") from error
    if not any(is_for_every_node(section) for section, _ in sections):
        return path
    document: dict[str, object] = {}
    for section, tree in sections:
        if not is_for_every_node(section):
            document[section] = tree
            continue
        before = section if section.endswith("**") else section.removesuffix("*").rstrip("/")
        values = flattened(tree)
        for node in (RigParameters.NODE, ControllerParameters.NODE):
            mine = node == ControllerParameters.NODE
            document[f"{before}/{node}"] = {
                name: value for name, value in values.items() if (name in controllers) == mine
            }
    copy = folder / "divided.yaml"
    content = {name: {"ros__parameters": tree} for name, tree in document.items() if tree}
    copy.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
    return copy
