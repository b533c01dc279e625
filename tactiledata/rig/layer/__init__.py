"""The layer solver: which forces a rigid body meets when it is pressed into a bonded elastic layer.

Read `grid` (where displacements are known), `strain` (internal forces at finite strain), `kernel` (the linear layer,
inverted exactly), then contact: `gap` (distances), `friction` (tractions), `touch` (contact of a surface that yields
linearly). `solver` joins them in a fixed point per step, which `mixing` accelerates; `press` runs it along a path.

The room imports indenters and the material of a scenario, and no other room of the rig: arrays in, arrays out.
"""
