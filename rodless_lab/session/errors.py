"""What a session tells a test that cannot go on; the nodes' output is part of the text."""


class HarnessError(RuntimeError):
    """Something a test has asked of a session is impossible."""


class RefusedError(HarnessError):
    """A node has refused a parameter or a request; the text is the node's own."""


class NodeDiedError(HarnessError):
    """A process has ended that the test has not ended."""


class WaitTimeoutError(HarnessError, TimeoutError):
    """What was waited for has not come."""


class InterruptedRunError(Exception):
    """The user has asked to stop."""
