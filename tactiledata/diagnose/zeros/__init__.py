"""The zero of the force sensor (its reading in free air), why it differs between trajectories, and small readings.

The questions: does the zero follow gravity (weight of the tool), the time since power-on (drift) or the angle of the
last joint (drag of the cable), or does it wander by chance? Does the sensor read small loads as 0, or in coarse steps?
Does it feel the tool's acceleration? They need no gel model, and are asked last.

1. ``readings``: mean readings in free air, with the direction of gravity, the time and the joint angles of each.
2. ``zero_models``, ``causes``: a linear model of each cause; a cause is reported if it predicts trajectories that were
   held out, and matters if it changes the zero within a trajectory.
3. ``wander``: whether zeros that are close in time are alike, beyond all of that.
4. ``dead_band``: whether numbers beside 0 are missing among the readings as they were logged.
5. ``coarse_steps``: whether these readings are multiples of a step that is larger than their noise.
6. ``inertia``: whether readings in free air follow the acceleration of a tool that swings on the arm.

The room reads the store and uses the wording of ``residuals``; it imports nothing else from ``diagnose``.
"""
