"""The zero of the force sensor (its reading in free air), and why it differs from trajectory to trajectory.

The question: does the zero follow gravity (weight of the tool), the time since power-on (drift) or the angle of the
last joint (drag of the cable)? It needs no gel model, and is asked last.

1. ``readings``: mean readings in free air, with the direction of gravity, the time and the joint angles of each.
2. ``causes``: a linear model of each cause; a cause is reported if it predicts trajectories that were held out.

The room reads the store and uses the wording of ``residuals``; it imports nothing else from ``diagnose``.
"""
