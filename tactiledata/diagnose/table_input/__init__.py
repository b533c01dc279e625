"""A table of predictions and observations as residuals."""
