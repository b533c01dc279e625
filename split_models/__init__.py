"""The models of the SPLIT paper and the baselines it compares with; they read and write tactiledata stores.

Which pictures does a DIGIT show of a pressed gel, and which mesh lies behind a picture? Read the rooms in this order:

- ``networks``: the VAEs, projections and force heads, and latent arithmetic with them;
- ``learning``: frames of a split, losses, the training loop, checkpoints;
- ``recipe``: a YAML recipe, its store, and its networks, each trained once;
- ``methods``: SPLIT and the baselines as rows of the tables;
- ``transfer``: pictures of one sensor as another sensor would show them, for pictures and for whole stores;
- ``tables``: the tables and figures of the paper from all of these;
- ``onnx``: export to ONNX, and inference without PyTorch;
- ``commands``: the verbs that the command `tactiledata` gains; ``__main__`` runs it in several processes.

Nothing in `tactiledata` imports this package: its commands are found by their entry point. PyTorch is imported where
networks are, so that `tactiledata --help`, reading a recipe and running exported networks do without it.
"""
