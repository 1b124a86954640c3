"""The control laws, one per module."""
