"""Scene: what one moment of a touch looks like, with arm, sensor, gel and indenter in their places.

Read in this order:

- ``arm``: kinematics of the UR5e, and a check of joints against recorded poses;
- ``scene``: the MuJoCo scene, its distances, pictures and MJCF document;
- ``mujoco_package``: the import of MuJoCo, which is optional.

The scene shows shapes that are handed to it; nothing is solved here, and no forces appear.
"""
