"""See :mod:`rodless_sim.instruments.instruments`."""

from rodless_sim.instruments.instruments import DATA_SHEET

__all__ = ["DATA_SHEET"]
