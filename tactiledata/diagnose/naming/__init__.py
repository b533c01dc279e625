"""Which known effect does the simulation lack? The answer is one effect, two, a set that cannot be told apart, or none.

Read in this order:

1. `strength`, `parameters`: the numbers of an effect; everything that one fit determines, as a vector.
2. `metric`: how far two changes of the data are alike, once what a refit could imitate is taken out of both.
3. `signatures`: what each effect would change. `screen`: how much of the residual it would explain, without a refit.
4. `linearise`, `joint_fit`: the fit of E, nu and mu, effects and all nuisance parameters together. Errors of the
   simulation are shares of simulated forces, and move with them in a fit.
   `error_sizes`: how large these errors are, for each indenter, from the data at hand.
   `own_error_sizes`: how large those of single touches are, and which touches do not belong to the others; these
   stay in the fit and are named.
   `refit`: which effects and pairs of effects are fitted in this way. `kept_fits`: fits that are made once, and
   several at a time.
5. `held_out`: how well fits predict data they have not seen. `remaining_structure`: whether the best fit leaves more
   than noise.
6. `agreement`: how well trajectories agree on an effect, and whether its strength changes with time. `evidence`:
   gain, evidence and signature of a candidate, and the objections to it. `thresholds`: the evidence that a claim of
   each effect needs, the other numbers of a claim, and where they come from. `beside`: what an effect adds beside
   another one. `decide`: the answer: a claim, a trace (below detection), or nothing. `ties`: effects that these data
   cannot tell from it.
7. `intervals`, `identifiability`, `simulator_share`: how certain the numbers are, what these data could show at all,
   what the fit attributes to errors of the simulation.
8. `options`, `name_effects`: the choices, and all steps in order.
   `full_plays`: effects named again once the gels on which an answer could rest are played in full.

Of `diagnose`, this folder imports `touches`, `verdict` and, from `residuals`, names, words and a bound of rounding. It
reads no store, draws no page, and uses neither locators nor formulas.
"""
