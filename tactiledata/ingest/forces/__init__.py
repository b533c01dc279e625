"""Contact forces from raw readings of the force sensor.

- ``gravity``: what the tool's own weight adds, from its mass, its centre of gravity and the pose.
- ``onset``: when a force shows contact, and which samples were surely taken before.
- ``tare``: the zero of the sensor, from free air or from stated tare events. ``tare_events``: those events, as the
  readings show them. ``zero_levels``: whether a trajectory begins in free air at all. ``zero_findings``: what is
  said of trajectories that do not, or whose zero is far from the others'.
- ``contact``: the contact wrench, which the gel exerts on the indenter, in the gel frame; start here.

A zero is never taken in contact: where none is known, a finding names the trajectory.
"""
