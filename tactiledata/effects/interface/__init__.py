"""Effects of friction and adhesion between indenter and gel: does the contact follow Coulomb's law?

Each module is one effect, and each of the first three multiplies the coefficient of friction:

- ``area_friction``, ``rate_friction``, ``static_friction``: friction by area, by speed, and by rest.
- ``partial_slip``: the rim slips before the middle. It acts on the friction that the effects before it leave.
- ``adhesion``: the gel pulls at an indenter that leaves.

These effects are the last that act in contact; ``time`` and ``sensor`` work on the answer of the gel.
"""
