"""The layer solver: which forces a rigid body meets when it is pressed into a bonded elastic layer.

Read `grid` (where displacements are known), `strain` (internal forces at finite strain), `kernel` (the linear layer,
inverted exactly), then contact: `gap` (distances), `friction` (tractions), `touch` (contact of a surface that yields
linearly). `solver` joins them in a fixed point per step, which `mixing` accelerates; `press` runs it along a path.

Of the rig, the room imports `scenario` only, for the material; beside it the indenters. Arrays in, arrays out.
"""
