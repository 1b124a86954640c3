"""The bench: experiments in process and over ROS, bags, reports, and the `rodless` command."""

from rodless_lab.closed_loop import ClosedLoopTrace, closed_loop

__all__ = ["ClosedLoopTrace", "closed_loop"]
