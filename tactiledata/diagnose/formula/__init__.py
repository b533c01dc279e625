"""A formula for what no known effect explains.

The residuals of any simulation enter. No gel and no catalogue of effects is needed. Read the modules in this order:

- `terms`: which dimensionless numbers can be built from the covariates (ratios, logarithms, memories, relaxations)?
- `candidates`: what may each number multiply (a parameter or a component), and which products are tried?
- `shifted`: would a shift of a measured length explain the residual?
- `select`: which candidates do halves of the trajectories choose again and again?
- `open_form`: which formula do the chosen terms make, with which coefficients and in which words?
- `likeness`: which known effect does the formula resemble?
- `unseen`: does the formula hold on trajectories that had no part in choosing or fitting it?
- `surface`: how do the residuals vary over two covariates where no formula is found?
- `explain`: what is the verdict on all of this, in sentences?

This room imports only `locate`, `residuals` and the verdicts. It never plays the gel and never draws a page.
"""
