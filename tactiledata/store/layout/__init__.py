"""Where things lie in a store, and how its files are written safely.

- ``places``: names of folders and files, sizes of chunks, the format's version; start here.
- ``manifest``: what a store holds; what the manifest does not name does not exist.
- ``batch``: files that appear together: written beside their places, synced, then renamed.
- ``arrays``, ``shards``, ``images``: Zarr arrays, raw frames and encoded pictures that grow by rows.
- ``sensors_table``: facts and pictures without contact of each sensor, and what happens when recordings disagree.
- ``lock``: one writer at a time. ``statistics``: sums of columns that see each value once. ``made_splits``: names of
  the splits that were made of a store. ``flag_file``: trajectories that a person called bad. ``regular_files``: what is
  no file, such as a pipe, is not opened.
"""
