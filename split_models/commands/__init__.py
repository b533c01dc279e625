"""The verbs that this package adds to the command `tactiledata`."""

from split_models.commands.verbs import register

__all__ = ["register"]
