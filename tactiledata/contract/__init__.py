"""What the parts of the project hand to each other: records, documents checked against ``schemas/``, provenance.

- ``records``, ``description``, ``take``: a recording as read, what it says of itself, and what a store is given.
- ``schema``, ``sealed``, ``provenance``, ``atomic``, ``paths``: documents: checked, digested, written whole, kept
  inside.
- ``image_bytes``, ``picture_kinds``, ``image_sizes``, ``image_batches``: pictures, decoded in one way within one
  limit.
- ``tensor_files``, ``lfs_pointer``: files from strangers. ``simulated``, ``wording``: words that are the same
  everywhere.
- ``progress``, ``worker_pool``: long work: who watches, and processes that end with their parent.

Of the project it imports ``arrays``, ``errors``, ``transforms`` and ``units`` only; every package above may import it.
"""
