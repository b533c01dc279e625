"""Effects of what the gel is made of: is its stiffness that of the simulated material?

Each module is one effect:

- ``strain_stiffening`` and ``skin``: another elastic law, and a coating; the gel engine plays both at design points.
- ``mullins``: softening below a strain that was reached before.
- ``heating``: stiffness and height that change while the sensor warms up.
- ``wear``: a spot that was touched often.

These effects act after those of ``geometry`` and before those of ``interface``.
"""
