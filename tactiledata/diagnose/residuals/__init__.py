"""Residuals (measured minus simulated) and the statistics that treat whole trajectories as the independent samples.

The question: what do residuals say about a parameter or a covariate, once all that a refit could absorb is removed?
No p-value here counts single frames, because neighbouring frames are not independent. The unit of exchange is a
trajectory, or a larger block such as a day of recording.

Read the modules in this order:

1. ``residuals``: the table that all else is computed from (values, covariates, labels, parameters, sensitivities).
2. ``projection``: the residual after each trajectory's own parameters and a linear refit of the shared ones.
3. ``instruments``: the functions of a covariate along which a parameter may vary (steps, slope, levels).
4. ``scores``: the score test of such a variation, one contribution from each unit of exchange.
5. ``sign_flips``: p-values from random signs of whole units, alone or for a family of tests.
6. ``slopes``: the size of a change with its 95 % interval.
7. ``gap``: how much of the distance from the error to the noise a correction closes.
8. ``ceiling``: how much boosted trees predict: the most that any formula of the covariates could explain.

Helpers: ``learners`` (scikit-learn and folds), ``history`` (running maximum, fading memory), ``dimensions`` (units),
``wording`` (numbers as text), ``scaled_matrix`` (a cut-off without units). The room imports no other room of
``diagnose``.
"""
