"""What did each touch measure, and what does the simulation answer to it at any material and with any effect?

Read in this order:

1. `touch_case`: a trajectory with its measured wrenches; a set of them with the simulation that plays them.
2. `store_touches`: the trajectories of a store, with gel and covariates.
3. `play_grid`: which plays of the gel engine are made: pairs of nu and mu, offsets, shifts along the gel, variants.
4. `grid_answer`: interpolation between these plays. `played_columns`: its compiled inner loops.
5. `friction_history`: shear depends on the past: friction that changes from frame to frame, and sliding along another
   path. `played_response`: all of this together, as the base simulation that effects ask.
6. `whitened`: the trajectories in units of their noise, and the simulation's own errors as fields.
7. `covariates`: depth, speed, time and others in each frame, and the phase of the touch.

The room imports the calibration's plays, the effects, the gel, the store's readers and, from `residuals`, covariates
and running maxima. It fits no material and judges nothing.
"""
