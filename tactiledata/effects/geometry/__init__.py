"""Effects of the shape of the pad: is the gel as high, as curved and as whole as stated?

Each module is one effect:

- ``thickness`` and ``dome``: height and curvature of the pad; the gel engine plays both at design points.
- ``soft_region``: a bubble, a defect, or a part that came off the backing.
- ``pad_edge``: a soft border, and the rim of the housing beyond it.

These effects act after those of ``pose`` and before those of ``material``.
"""
