"""What a lock-step plant has sent and a reader holds back, without topics."""


class Outgoing:
    """Nothing is held back unless ``obstacle`` is set."""

    def __init__(self) -> None:
        self.obstacle: str | None = None

    def flush(self) -> bool:
        """Whether nothing is held back."""
        return self.obstacle is None

    def clear(self) -> bool:
        """Forget what is held back."""
        held, self.obstacle = self.obstacle is not None, None
        return held
