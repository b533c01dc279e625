"""What did each touch measure, and what does the simulation answer to it at any material and with any effect?

Read in this order:

1. `touch_case`: a trajectory with its measured wrenches; a set of them with the simulation that plays them.
2. `store_touches`: the trajectories of a store, with gel and covariates.
3. `play_grid`: which plays of the gel engine are made: pairs of nu and mu, offsets, shifts along the gel, variants.
4. `missing_frames`: frames that a play has not solved, estimated from the others. `grid_answer`: interpolation between
   plays. `played_columns`: its compiled inner loops.
5. `friction_history`: shear depends on the past: friction that changes from frame to frame, and sliding along another
   path. `played_response`: all of this together, as the base simulation that effects ask.
6. `own_errors`: what may be off in one trajectory alone. `simulation_errors`: the directions in which the simulation
   may err. `whitened`: the trajectories in units of noise and of the first, and the second as fields.
7. `covariates`: depth, speed, time and others in each frame, and the phase of the touch.

Of the diagnosis, the room imports `residuals` only: covariates and running maxima. A store comes as an opened one of
`replay`. The room fits no material and judges nothing.
"""
