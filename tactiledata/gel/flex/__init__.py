"""MuJoCo's soft body: what another solver answers for the same pad and touches.

It is an independent check of ``gel.engines``, too stiff to work with. Read in this order:

- ``model``: pad and indenter as a MuJoCo model, with its state;
- ``engine``: the engine ``mujoco-flex``, which moves the indenter and waits until the pad is at rest.

MuJoCo is optional and imported only when an engine is made. The room shares the contact's load steps and recorder, and
nothing of ``gel.elasticity`` but the material.
"""
