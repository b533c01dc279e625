"""Reading a table of observations and predictions, and turning it into `Residuals`: a diagnosis without a gel.

The question: which column is the group, which are observed, predicted and noise, and which are covariates or labels?
docs/diagnose-table.md describes the names from the user's side.

1. ``read``: a CSV, TSV or Parquet file as a data frame, or a refusal that says what is wrong with the file.
2. ``columns``: the meaning of each column, from a document or from its name and the unit at its end.
3. ``held_steps``: the time since the last step of a covariate that is held at levels, which creep would follow.
4. ``kept_rows``: the rows that are used, without gaps, outliers and repeats, and what is said of the others.
5. ``residuals_of``: those rows as whitened residuals with an offset and a scale as parameters.

The room imports ``residuals`` and, for frames in contact, ``locate.free_air``; it draws no conclusion from the data.
"""
