"""Logs: what the instruments record of a played log, and how it lies on disk.

`sampling` makes a `tape` of a played log: streams with the faults of `imperfections`, pictures by `reflectance`, and
the description by `describe`. `write_mcap` (with `ros2_messages` and `encode`) and `write_folder` write the tape;
`truth` writes what only the rig knows into a folder of its own.

Nothing that only the rig knows may enter a log: descriptions state what an operator would state.
"""
