"""Elasticity: which forces a deformation of the pad needs, and how its surface moves under loads.

Read in this order:

- ``material``, ``stiffening``: the neo-Hookean law, and Yeoh's terms beyond it;
- ``stiffness``, ``internal_forces``: the linear stiffness at rest, and nodal forces at finite strain;
- ``triangular``, ``compliance``: the factorised stiffness, fast solutions, and the response of the surface to loads;
- ``tangent``, ``deformed``: the stiffness of a deformed pad, and its factor, for touches that are hard to solve;
- ``mixing``: Anderson acceleration of the iterations at finite strain.

The room imports ``gel.mesh`` only. It knows no contact and no indenter. Young's modulus is 1 in all of it.
"""
