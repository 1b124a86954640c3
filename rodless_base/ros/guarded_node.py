# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Nodes that go on when a callback fails, whatever message or request it was given."""

import sys
from collections.abc import Callable, Sequence
from functools import wraps
from traceback import walk_tb
from types import TracebackType
from typing import Any

from rcl_interfaces.msg import ParameterType, SetParametersResult
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.node import Node
from rclpy.service import Service
from rclpy.subscription import Subscription
from rclpy.timer import Timer

from rodless_base.one_line import described, in_one_line, listed, traced
from rodless_base.parameters import ParameterError
from rodless_base.ros.given import empty_lists

# What /diagnostics calls them.
CALLBACK_ERRORS = "errors in callbacks"

# Errors that could come with every message: say one in this time (s). Diagnostics count them all.
LOG_PERIOD = 10.0

LAST_TYPE = ParameterType.PARAMETER_STRING_ARRAY


class GuardedNode(Node):  # type: ignore[misc]
    """A node that no error out of a callback ends: its own callbacks, and those rclpy gives it.

    The error is logged and counted, and a service answers with it. Where code of this project broke
    off half-way, the node's state is in doubt: ``make_safe`` is called with the reason.

    An executor would end its spinning, and the messages that have come together with the one that
    failed would stay behind, to be taken one message too late from then on.
    """

    def __init__(self, *arguments: Any, **options: Any) -> None:
        """Make the node as rclpy's; raises ParameterError for what it is given and cannot have."""
        # First: rclpy creates the parameter services in its own __init__.
        self.callback_errors = 0
        self.make_safe: Callable[[str], None] = lambda _reason: None
        # Until when (s, monotonic) it may wait for its readers as it ends.
        self.end_by = 0.0
        try:
            super().__init__(*arguments, **options)
        except ValueError as error:  # which names no parameter
            names = listed(empty_lists(sys.argv, arguments[0]))
            cause = "[] refused, of what type an empty list is ROS cannot tell; leave it out"
            raise ParameterError(f"{names}: {cause}" if names else described(error)) from error

    def take_error(self, error: BaseException) -> str:
        """Take what a callback, or the executor on its way there, has raised; return its text."""
        text = f"error in a callback: {traced(error)}"
        self.callback_errors += 1
        self.get_logger().error(text, throttle_duration_sec=LOG_PERIOD)
        if _passed_our_code(error.__traceback__):
            self.make_safe(text)
        return text

    def create_subscription(
        self, msg_type: Any, topic: str, callback: Callable[..., None], *others: Any, **options: Any
    ) -> Subscription:
        """As rclpy's."""
        guarded = self._guarded(callback, lambda _text, *_: None)
        return super().create_subscription(msg_type, topic, guarded, *others, **options)

    def create_timer(
        self, timer_period_sec: float, callback: Callable[..., None], *others: Any, **options: Any
    ) -> Timer:
        """As rclpy's."""
        guarded = self._guarded(callback, lambda _text, *_: None)
        return super().create_timer(timer_period_sec, guarded, *others, **options)

    def create_service(
        self, srv_type: Any, srv_name: str, callback: Callable[..., Any], **options: Any
    ) -> Service:
        """As rclpy's."""
        guarded = self._guarded(callback, _failed_answer)
        if srv_type is SetParameters:
            guarded = self._each_parameter(guarded)
        elif srv_type is SetParametersAtomically:
            guarded = self._all_parameters(guarded)
        return super().create_service(srv_type, srv_name, guarded, **options)

    def _each_parameter(self, callback: Callable[..., Any]) -> Callable[..., Any]:
        """Refuse parameters of a type that is none; ``callback`` answers for all others.

        rclpy would give up at the first, and what comes after it in the request stay behind.
        """

        def answer(request: Any, response: Any) -> Any:
            refusals = [self._refuse_unknown_type([one]) for one in request.parameters]
            known = [
                parameter
                for parameter, refusal in zip(request.parameters, refusals, strict=True)
                if refusal is None
            ]
            response = callback(SetParameters.Request(parameters=known), response)
            answers = iter(list(response.results))
            response.results = [next(answers) if one is None else one for one in refusals]
            return response

        return answer

    def _all_parameters(self, callback: Callable[..., Any]) -> Callable[..., Any]:
        """Refuse a request with a type that is none; ``callback`` answers all others."""

        def answer(request: Any, response: Any) -> Any:
            refused = self._refuse_unknown_type(request.parameters)
            if refused is None:
                return callback(request, response)
            response.result = refused
            return response

        return answer

    def _refuse_unknown_type(self, parameters: Sequence[Any]) -> SetParametersResult | None:
        """Count and log a parameter of a type that ROS has not; None where there is no such."""
        for parameter in parameters:
            if parameter.value.type > LAST_TYPE:
                reason = (
                    f"{in_one_line(parameter.name)}: type {parameter.value.type} refused, "
                    f"ParameterType has 0 to {LAST_TYPE}"
                )
                self.callback_errors += 1
                self.get_logger().error(reason, throttle_duration_sec=LOG_PERIOD)
                return SetParametersResult(successful=False, reason=reason)
        return None

    def _guarded(
        self, callback: Callable[..., Any], instead: Callable[..., Any]
    ) -> Callable[..., Any]:
        @wraps(callback)
        def guarded(*arguments: Any) -> Any:
            try:
                return callback(*arguments)
            except KeyboardInterrupt:
                raise
            except BaseException as error:
                return instead(self.take_error(error), *arguments)

        return guarded


def _failed_answer(text: str, request: Any, response: Any) -> Any:
    """Return the answer to a request on which the service has failed."""
    refused = SetParametersResult(successful=False, reason=text)
    if isinstance(request, SetParameters.Request):
        # Those before the one that failed have their results.
        missing = len(request.parameters) - len(response.results)
        response.results = [*response.results, *[refused] * missing]
    elif isinstance(request, SetParametersAtomically.Request):
        response.result = refused
    elif hasattr(response, "success"):
        response.success, response.message = False, text
    elif hasattr(response, "result") and hasattr(response.result, "error_message"):
        # As those of simulation_interfaces.
        response.result.result = response.result.RESULT_OPERATION_FAILED
        response.result.error_message = text
    return response


def _passed_our_code(traceback: TracebackType | None) -> bool:
    """Whether an error came through code of this project, below what has called the callback."""
    modules = [str(frame.f_globals.get("__name__")) for frame, _ in walk_tb(traceback)]
    return any(name.startswith("rodless_") for name in modules[1:])
