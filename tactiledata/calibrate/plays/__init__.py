"""Plays: how does the gel answer a measured touch at given parameters, and which answers need no simulation?

Read in this order:

- ``play_batches``: batches of touches, all simulated in one run; ``play_progress``: how many are finished;
- ``player``: which batches the nodes of a plan ask for;
- ``kept_plays``: the cache of simulated touches on disk, and under which key each is kept;
- ``estimated_plays``: which nodes are simulated at finite strain, and how the others follow from them and from the
  linear engine;
- ``learned_plays``: touches whose change by nu, by the offset or by another law is learned from a few that were
  simulated, and how far that may be off.

The room simulates through ``gel``. It knows no measured force and fits no material.
"""
