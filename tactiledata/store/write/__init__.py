"""Recordings into a store, safe to kill at any moment.

- ``spool``: pictures on disk as they come. ``image_columns``: a row of facts for each of them.
- ``take_checks``: whether a take fits together.
- ``writer``: a take becomes files that wait for their commit, a marker written last.
- ``commit``: staged takes become part of the store in groups; the manifest is written last.
- ``intake``: a store that takes recordings in; one that got nothing is taken away again.
- ``appender``, ``image_appender``, ``value_appender``, ``sensor_appender``: the rows and sensors of one group on
  their way into arrays and tables.
- ``recover``: what a killed writer left behind is removed. ``documents``: texts beside the
  manifest with their digests, and which of them differ from these. ``card``: the dataset card.
- ``mesh_writer``: meshes that a replay attaches to frames.
"""
