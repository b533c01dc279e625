"""Replay: which mesh, contact and wrench the simulated gel has at every frame of a store's trajectories.

Read in this order:

- ``options``, ``status``: what a user chooses, and why a frame has no mesh;
- ``plan``, ``geometry``, ``poses``: which trajectories can be simulated, with which pad, indenter and poses;
  ``chosen_frames``: which frames stand for a long trajectory;
- ``opened``: a store with its plan, as replay, ``calibrate`` and ``diagnose`` read it;
- ``solve``, ``attach``: one run of trajectories, and all runs committed to the store in order;
- ``effect_touches``, ``store_facts``, ``store_motion``: the inputs of effects (missing physics) from a store;
- ``effect_rounds``, ``played_answer``, ``effect_words``: simulation with effects, and their names on pages;
- ``report``, ``overview``: what a replay attached, for a terminal and for a page; ``untouched``: trajectories that were
  pressed and never touch the simulated gel;
- ``frame_scene``: one frame as a MuJoCo scene. ``indenter_path``: the indenter at every frame, for other pictures.

The room simulates through ``gel`` and ``effects`` and writes through ``store.write``. It fits nothing and judges no
physics: that is the work of ``calibrate`` and ``diagnose``, which it does not import.
"""
