"""The tables and figures of the paper: which rows, which scores, which pictures.

Read in this order:

- ``tables``: the tables by name, what each one needs and which function gives its rows;
- ``evaluate``: scores of a method over a part, with intervals over trajectories; ``results``: the finished document;
- ``paired_differences``: by how much rows differ on the same frames;
- ``force_intervals`` and ``interval_rows``: forces with calibrated intervals, and how often these hold;
- ``cyclic`` and ``cyclic_plot``: picture to mesh to picture, repeated;
- ``domain_alignment``, ``alignment_pictures``, ``paired_truth`` and ``unit_frames``: transfer between units;
- ``touch_head``: what transferred pictures still tell of place, depth and force;
- ``inference_time``, ``step_race``, ``recorded_touches``, ``simulated_frames`` and ``peak_memory``: time and memory;
- ``mesh_figure``, ``mesh_picture``, ``picture_grid`` and ``recorded_title``: pictures for people.

The room may import every other room but ``onnx`` and ``commands``. It trains nothing itself: a `RecipeRun` does.
"""
