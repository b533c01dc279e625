"""A store to read.

- ``reader``: `Store`, the one entry: tables, signals, aligned values, pictures, meshes, sensors, splits.
- ``files``: the files of a store wherever they lie, local or at a URL. ``rows``: rows of arrays, read at random.
- ``recorded``: whether rows that read as nothing were recorded so.
- ``index_tables``, ``signal_rows``, ``meshes``, ``pictures``: what `Store` hands to them, one kind of data each.
- ``scaled_pictures``: pictures decoded at a smaller size.
- ``sensor_facts``: facts of sensors, held against their digests.
- ``flags``: trajectories that a person called bad. ``named_trajectories``: the trajectory that a name means.
- ``recording_names``: names that tell recordings apart.
- ``overview``, ``simulated``, ``free_air``, ``targets``, ``seen_target``: questions that commands ask of a store.

Nothing here writes.
"""
