"""Contact: where an indenter presses the gel at each pose of its path, and with which forces.

Contact is unilateral with Coulomb friction, so each frame depends on those before it. Read in this order:

- ``history``: one trajectory that is asked for, and the answer at its frames;
- ``path``: which frames can be solved, and the load steps between them;
- ``relief``, ``gap``: the indenter's underside as a height map, and the distance of each surface patch from it;
- ``friction``: contact forces on the patches, for given gaps and slips;
- ``contact_path``: the contact at the present pose, and one iteration of it;
- ``trajectory_solve``, ``recorder``: the order of load steps, what happens when one fails, and the recorded arrays.

The room imports the surface of ``gel.mesh`` but no elasticity: displacements and compliances are handed to it.
"""
