# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What this project's plain Python says, in the log of a node."""

import logging
import sys
from collections.abc import Sequence
from itertools import pairwise

from rclpy.logging import LoggingSeverity, get_logger, set_logger_level

from rodless_base.kernel_cache import LOGGER
from rodless_base.start import split_ros_arguments


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
    """Log in the name of the node ``name`` from now on, as ``--log-level`` has it.

    ``rclpy.init`` reads that option too, but only after what takes long to load.
    """
    level = given_level(sys.argv, name)
    if level is not None:
        set_logger_level(name, level)
    LOGGER.handlers = [_Through(name)]
    LOGGER.setLevel(logging.INFO)


def given_level(arguments: Sequence[str], name: str) -> LoggingSeverity | None:
    """Return the level that ``arguments`` give to ``name``; None for one that ROS will refuse.

    Examples
    --------
    >>> given_level(["plant", "--ros-args", "--log-level", "warn"], "plant").name
    'WARN'
    >>> given_level(["plant", "--ros-args", "--log-level", "other:=debug"], "plant")
    """
    _, for_ros = split_ros_arguments(arguments)
    levels: dict[str, str] = {}
    for option, value in pairwise(for_ros):
        if option == "--log-level":
            logger, _, level = value.rpartition(":=")
            levels[logger] = level
    return LoggingSeverity.__members__.get(levels.get(name, levels.get("", "")).upper())
