"""What did each touch measure, and what does the simulation answer to it at any material and with any effect?

Read in this order:

1. `touch_case`: a trajectory with its measured wrenches; a set of them with the simulation that plays them.
2. `store_touches`: the trajectories of a store, with gel and covariates. `rest_means`: wrenches averaged over the
   readings while the indenter stands.
3. `play_grid`: which plays of the gel engine are made, and which are estimated: pairs of nu and mu, offsets, shifts
   along the gel, variants. `variant_plays`: plays of another gel or indenter; a variant that the engine solves in too
   few frames is left out, and with it the effects that need it.
4. `missing_frames`: frames that a play has not solved, estimated from the others. `grid_answer`: interpolation between
   plays. `played_columns`: its compiled inner loops.
5. `sliders`: springs that slip part by part along a path. `between_plays`: what these tell of shear where friction,
   depth or path are not those of a play, or change from frame to frame. `played_response`: all of this together, as the
   base simulation on which effects act.
6. `own_errors`: errors that one trajectory has by itself. `simulation_errors`: the directions in which the simulation
   may err. `error_wrenches`: these as wrenches at the frames. `whitened`: the trajectories in units of the noise, with
   both kinds of errors.
7. `covariates`: depth, speed, time and others in each frame, and the phase of the touch.

Of `diagnose`, this folder imports `residuals` only, for covariates and running maxima. A store is passed in as a
`replay.opened.OpenedStore`. No material is fitted here, and no effect is judged.
"""
