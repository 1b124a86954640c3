"""The bench: experiments in process and over ROS, bags, reports, and the `rodless` command."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rodless_lab.simulation.closed_loop import ClosedLoopTrace, closed_loop

__all__ = ["ClosedLoopTrace", "closed_loop"]


def __getattr__(name: str) -> object:
    """Load the compiled loop when it is asked for: most of this package does without."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from rodless_lab.simulation import closed_loop as module  # noqa: PLC0415  takes half a second

    return getattr(module, name)
