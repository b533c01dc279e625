"""Soft pad: with which wrench and deformation it answers an indenter that moves through given poses.

Read in this order:

- ``contact/history``: what is asked (poses and an indenter) and what is answered (wrenches, displacements, status);
- ``make_engine``: the engines by name; ``engines``: the finite-element engine, linear and at finite strain;
- ``mesh``: the pad as cells, and its surface as patches that carry contact forces;
- ``elasticity``: the material's law, the stiffness, nodal forces and the compliance of the surface;
- ``contact``: gaps, friction, load steps, and the order of work on one trajectory;
- ``flex``: MuJoCo's soft body as a second engine, for comparison; ``scene``: one moment as a MuJoCo scene.

The room takes arrays and returns arrays. It reads and writes no store; only compliances are kept in a cache on disk.
Lengths are in metres and forces in newtons; inside the solvers Young's modulus is 1, so forces are in m^2.
"""
