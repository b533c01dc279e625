"""SPLIT's networks for programs without PyTorch.

Read in this order:

- ``gather_map``: sparse matrices as gathers and sums, because the exporter knows no sparse products;
- ``export``: the networks of a recipe as ONNX files, each compared with PyTorch while it is written;
- ``models``: SPLIT from a folder of such files, computed by onnxruntime.

``models`` imports neither PyTorch nor a module that does. ``export`` imports ``networks`` and ``recipe``.
"""
