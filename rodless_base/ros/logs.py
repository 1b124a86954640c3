"""What this project's plain Python says, in the log of a node."""

import logging

from rclpy.logging import get_logger

from rodless_base.kernel_cache import LOGGER


class _Through(logging.Handler):
    """Hands records on to a ROS logger."""

    def __init__(self, name: str) -> None:
        super().__init__()
        self._logger = get_logger(name)

    def emit(self, record: logging.LogRecord) -> None:
        if record.levelno >= logging.WARNING:
            self._logger.warning(record.getMessage())
        else:
            self._logger.info(record.getMessage())


def log_through(name: str) -> None:
    """Log in the name of the node ``name`` from now on."""
    LOGGER.handlers = [_Through(name)]
    LOGGER.setLevel(logging.INFO)
