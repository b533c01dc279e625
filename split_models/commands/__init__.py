"""The verbs that this package adds to the command `tactiledata`.

- ``verbs``: registers all of them, and holds `train`, `evaluate` and `run`, which work on a recipe;
- ``export``: a recipe's networks as ONNX files;
- ``transfer``, ``fine_tune`` and ``score``: these work on stores;
- ``device_option``: the option ``--device`` of all of them.

A command parses options, calls another room and prints the answer. PyTorch is imported inside the functions, so that
`tactiledata --help` starts without it.
"""

from split_models.commands.verbs import register

__all__ = ["register"]
