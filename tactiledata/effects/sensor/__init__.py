"""Effects of the force sensor and of what hangs on it: is the reading the wrench on the indenter?

Each module is one effect, in the order in which they act:

- ``tool_weight``, ``inertia``, ``cable_drag``: loads beside the contact.
- ``frame_rotation``, ``gain_crosstalk``, ``sensor_drift``: axes, gains and zero of the sensor.
- ``lag``, ``quantisation``, ``clipping``: delay, steps and limits of a reading.

These effects act last. They change the reading alone, never the contact.
"""
