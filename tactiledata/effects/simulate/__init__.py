"""What does a touch read like with effects?

Read in this order:

- ``setting``: an effect with its values, as a simulator takes it and as a file keeps it.
- ``simulator``: plays a touch with settings on top of any base simulation, and decides when the gel and what bends
  under its force are in balance.
- ``balance``: the next estimate of the force in balance.
- ``reference_touch``: a usual touch of the rig, and how much each effect changes it.
- ``catalogue``: all effects as plain values, for commands and pages.

This room knows effects by the table and by ``base`` alone, no single effect.
"""
