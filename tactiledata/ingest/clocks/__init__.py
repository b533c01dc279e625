"""Streams on one clock.

- ``clocks``: which of three time stamps a stream lives by, and its offset to the host clock.
- ``timeline``: all streams of a recording on the host clock, sorted, with what was done to them; start here.
- ``clock_steps``: steps of one stream's clock, and the samples that a jump leaves out. ``witnesses``: whether a step is
  a jump or a pause, by a vote of the other streams. ``clock_shifts``: streams that are off as a whole, and images.
- ``rates``: at what rate a signal really changes. ``align``: its values at the moments of frames.
- ``lag``: how late the camera is against the force sensor; reported, never applied.
"""
