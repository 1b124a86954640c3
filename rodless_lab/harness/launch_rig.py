"""See :mod:`rodless_lab.session.launch_rig`."""

from rodless_lab.session.launch_rig import LaunchedRig

__all__ = ["LaunchedRig"]
