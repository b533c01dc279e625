"""tactiledata: recordings of a robot pressing a vision-based tactile sensor, as a training-ready dataset.

Importing this package imports neither torch nor mujoco; each part is imported where it is used.
"""

__version__ = "0.1.0"
