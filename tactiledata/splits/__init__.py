"""Who may learn from what: splits that never part a trajectory, and the audit that looks for leaks all the same.

- ``options``: what was asked. ``groups``: which trajectories belong together: derived ones and their parents, touches
  that two recordings hold (``twins``), and what several sensors took at one time (``moments``).
- ``assign``: who goes where, by keyed hash. ``make``: a split made and kept; start here. ``manifest``: its files.
- ``select``: which frames a split takes. ``report``, ``suggest``, ``again``: what came out, in words and commands.
  ``shares``: how near the parts are to what was asked, and the seed that comes nearest.
- ``audit``: the search for leaks. ``leaks``: those that tables show, such as a derived trajectory or frame in another
  part than its parent. ``moment_leaks``: those between sensors. ``fingerprints``, ``copies``: copies of pictures.
- ``flagged``: trajectories that a person called bad. ``across``: leaks between two stores.
"""
