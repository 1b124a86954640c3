"""What ends with the block that it is used in."""

from abc import ABC, abstractmethod
from typing import TypeVar

Own = TypeVar("Own", bound="Closing")


class Closing(ABC):
    """A context manager whose block ends with :meth:`close`."""

    @abstractmethod
    def close(self) -> None:
        """Give back what this holds."""

    def __enter__(self: Own) -> Own:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()
