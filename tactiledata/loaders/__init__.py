"""The store as a dataset: batches of arrays (``numpy``) or of tensors (``torch``). Importing this imports no torch."""
