"""Nuisances: which differences between measured and simulated wrenches are no physics of the gel.

Every fit must allow for them. Each module answers for one cause; the order is that of a reading:

- ``noise``: covariance of a wrench at a frame, and memory of the readings (how long their noise is correlated in time,
  which a mean of readings must heed), from readings at rest or from a data sheet;
- ``tare``: the force sensor's zero, known only as well as the free air before a touch allows;
- ``offsets``: the place where contact begins, known only as well as the arm repeats;
- ``numerical``: errors of mesh and solver, which leave simulated forces off by known shares;
- ``low_rank``: what the unknowns of one trajectory add to the covariance of its noise.

The room holds arithmetic only: arrays in, arrays out. It reads no store, simulates nothing and imports neither
``calibrate`` nor ``diagnose``, which both use it.
"""
