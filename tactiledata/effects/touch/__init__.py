"""What do effects know of a touch, and what may they change of it?

Read in this order:

- ``touch``: the recorded touch, with all that effects may depend on.
- ``response``: what effects ask of the simulation below them, and the contact that it answers.
- ``state``: a touch between two effects, with the changes that effects may make.
- ``moved_until``: the motion before each frame, from ``last_move`` and ``felt_acceleration``. ``earlier_places``: where
  the tip was shortly before a frame.
- ``imprint``: how much an earlier press counts. ``gel_variants``: the gel engine for a gel that is not nominal.
- ``time_operators``, ``relaxing_shear``, ``shear_stiffness``, ``normal_density``: equations that several effects share.

Nothing here knows an effect.
"""
