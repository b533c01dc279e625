"""Finite-element engines: how whole trajectories are solved on a pad.

Read in this order:

- ``fem``: the engine ``fem``, assembled and condensed once for a mesh and a Poisson's ratio;
- ``linear``: small strain, contact iterations on the condensed surface only;
- ``finite_strain``: neo-Hookean finite strain, many trajectories in lockstep;
- ``tangent_step``: one load step by Newton's method, where the iterations of ``finite_strain`` fail;
- ``embedded``: the low-resolution solution interpolated to the high-resolution pad.

The room combines ``gel.mesh``, ``gel.elasticity`` and ``gel.contact``, and adds no mechanics of its own.
"""
