"""The store as a dataset: batches of arrays (``numpy``) or of tensors (``torch``). Importing this imports no torch.

- ``numpy``: frames or whole trajectories of one part of a split as arrays; start here.
- ``torch``, ``collate``, ``resumable``: the same as a PyTorch dataset, with batches and a sampler that can be
  resumed.
- ``selection``, ``index``, ``missing``, ``fit``: which frames a dataset holds, what they lack, whether they go
  together.
- ``streams``: what the names of streams stand for. ``normalise``: mean and spread over the train part.
- ``picture_reading``, ``picture_arrays``: pictures at the size that is asked for, and as models take them.
- ``decoded_cache``, ``cache_room``: decoded pictures kept on a local disk, and who gets room for them.
- ``order``: the order of items, shared between processes. ``facts``: who touched what, as a table.
"""
