# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What a session tells a test that cannot go on; the nodes' output is part of the text."""


class HarnessError(RuntimeError):
    """Something a test has asked of a session is impossible."""


class RefusedError(HarnessError):
    """A node has refused a parameter or a request; the text is the node's own."""


class NotYetError(RefusedError):
    """A node takes a change only in a while, when its equations are compiled."""


class NodeDiedError(HarnessError):
    """A process has ended that the test has not ended."""


class LawFailedError(HarnessError):
    """The law of the controller has failed, and the valve is closed."""


class WaitTimeoutError(HarnessError, TimeoutError):
    """What was waited for has not come."""


class InterruptedRunError(Exception):
    """The user has asked to stop."""
