# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

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
