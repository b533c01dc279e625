"""Who may learn from what: splits that never part a trajectory, and the audit that looks for leaks all the same.

- ``options``: what was asked. ``groups``, ``twins``: which trajectories belong together.
- ``assign``: who goes where, by keyed hash. ``make``: a split made and kept; start here. ``manifest``: its files.
- ``select``: which frames a split takes. ``report``, ``suggest``, ``again``: what came out, in words and commands.
- ``audit``: the search for leaks. ``leaks``: those that tables show. ``fingerprints``, ``copies``: copies of
  pictures.
- ``across``: leaks between two stores.
"""
