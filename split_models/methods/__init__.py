"""SPLIT and its baselines: methods that turn meshes into pictures, or pictures into meshes.

Read in this order:

- ``methods``: the registry by name, and SPLIT, NOSPLIT and the end-to-end network as its members;
- ``optical_method`` and ``baselines``: pictures without learning, and for which sensors each baseline is built;
- ``taxim``, ``fots`` and ``across``: the optical baselines, with published calibrations and calibrated for each unit;
- ``depth_rendering``, ``zhu`` and ``zhu_row``: a graph network from pictures to meshes, after Zhu et al. 2022;
- ``cycle``: both projections learned together, beyond the paper.

A method gets a `RecipeRun`, from which it takes frames and trained networks. It may not score itself: see ``tables``.
"""
