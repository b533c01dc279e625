"""Optics: how a deformed gel changes the colours that the camera behind it sees, computed without learned models.

A whole picture is a background with this change: `split_models.methods.optical_method` adds the two.

Read in this order:

- ``surface``: nodes and triangles of the gel's outer surface; ``view``: the point of the gel that each pixel sees;
- ``height_map``: height, indentation, contact and slope of the gel at each pixel;
- ``registration``, ``view_search``: the view of one unit's camera, from touches of known meshes;
- ``taxim``, ``taxim_calibration``: colour by slope and place, and its calibration from pictures of known slopes;
- ``shadows``: shadows that the pressed gel casts.

The room takes arrays and returns arrays; it imports the arrays of a stored mesh from ``store.read`` and solves no
mechanics. ``taxim_digit`` holds the published table of the DIGIT with its licence.
"""
