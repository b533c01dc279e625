"""Effects that move the indenter against the gel: is the tip where the encoders say?

Each module is one effect:

- ``mount_offset``: the indenter sits elsewhere than stated, or is larger.
- ``arm_compliance``: arm, mount and fixture yield to the contact force.
- ``stem_bending``: the stem of the indenter bends under shear.

These effects act first. They change offset and shift of a touch, on which the answer of the gel depends.
"""
