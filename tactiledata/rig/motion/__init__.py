"""Motion: where the indenter, the sensor and the arm are at each moment.

`touch` states what a touch consists of: its steps, its place on the gel, its angle.
`motion` turns that plan into a path of the indenter over the gel, and the path into poses of the tool.
`ur5e` gives the joint angles of those poses.

The room knows no forces: its caller gives the depth at which a limit of force is reached. It may not import contact.
"""
