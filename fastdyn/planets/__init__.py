"""Small masses around a dominant one, over millions of revolutions."""

from .outer import outer_planets
from .planets import Planets

__all__ = ["Planets", "outer_planets"]
