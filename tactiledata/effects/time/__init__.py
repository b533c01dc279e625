"""Effects of time on the contact force: does the wrench depend on the past, or on another clock?

Each module is one effect:

- ``relaxation``: the gel is viscoelastic.
- ``clock_skew``: the clocks of force sensor and camera differ.

These effects act on the answer of the gel, before those of ``sensor``. They do not ask the gel again.
"""
