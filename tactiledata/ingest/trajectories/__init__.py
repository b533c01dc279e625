"""Which frames and samples belong to which touch.

- ``segment``: trajectories where a recording names none: from free air to free air.
- ``cut``: which frames and samples each trajectory has. ``frames``: the table of frames.
- ``identity``: which sensor a picture belongs to, by serial. ``reference``: a picture of each sensor without
  contact.
- ``assemble``: all of it together: a recording as read becomes a take; start here.
"""
