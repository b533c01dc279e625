"""From a raw log to a store: clocks, contact wrench, trajectories, aligned values, checks.

``pipeline`` is the one entry: recordings are found, read by workers and committed in order. Its rooms:

- ``sources``: which recordings there are, and what became of them.
- ``clocks``: streams on one clock. ``forces``: contact wrenches from raw readings.
- ``trajectories``: which frames and samples belong to which touch; ``trajectories.assemble`` makes the take.
- ``checks``: what is remarked about a recording; nothing is silently wrong.

Values are never repaired here: what cannot be known is NaN, and a finding says why.
"""
