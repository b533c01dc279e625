"""A third generator of contacts: a pad of finite elements of scikit-fem, with a contact and friction of its own.

It shares no function, constant or reduction with the gel engine, the effects or the rig's own two forms of contact.
Lengths are in mm and stresses in units of Young's modulus, so that forces are in mm². Read `pad` (the elements),
`grid` (where bricks are small), `slices` (linear systems), `bodies` (the rigid indenters), `surface` (contact and
friction), `steps` (Newton's method), `touch` (one touch along its path) and `bank` (solved touches, kept).
"""
