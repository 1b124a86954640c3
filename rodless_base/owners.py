"""Which of the rig's nodes a parameter belongs to, by the first part of its name."""

# A file's section for all nodes (``/**``), or `ros2 param load`, gives each node the others'
# parameters too. Plant and controller do not import each other, so what they declare stands here
# a second time; a test compares.
GROUPS = {
    "plant": (
        "air",
        "atmosphere",
        "chambers",
        "cylinder",
        "end_stop",
        "friction",
        "leak",
        "rail",
        "sensors",
        "supply",
        "time",
        "valve",
    ),
    "controller": ("controller", "reference"),
}

_OWNERS = {group: node for node, groups in GROUPS.items() for group in groups}


def owner(name: str) -> str | None:
    """Return the node that parameter ``name`` belongs to, or None where its name does not tell.

    Examples
    --------
    >>> owner("supply.pressure"), owner("reference.type"), owner("frame_prefix")
    ('plant', 'controller', None)
    """
    return _OWNERS.get(name.partition(".")[0])
