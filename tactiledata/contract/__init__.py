"""What the parts of the project hand to each other: records, documents checked against ``schemas/``, provenance.

- ``records``, ``description``, ``take``: a recording as read, what it says of itself, and what a store is given.
- ``schema``, ``sealed``, ``provenance``, ``atomic``, ``paths``: documents: checked, digested, written whole, kept
  inside.
- ``image_bytes``: pictures, decoded in one way, and the limit of their decoded size. ``picture_kinds``: those that are
  not 8-bit RGB. ``image_sizes``: strays in size. ``image_batches``: how many are read at once.
- ``own_files``: which files an earlier run wrote, so that they may be replaced.
- ``arrow_memory``: tables that are read so that no thread of Arrow outlives them. ``near_path``: a proposal where a
  path does not exist.
- ``tensor_files``, ``lfs_pointer``: files from strangers. ``simulated``, ``wording``: words that are the same
  everywhere.
- ``ros2_messages``: messages as they stand in an MCAP.
- ``extras``: packages that only some commands need.
- ``progress``, ``worker_pool``: long work: who watches, and processes that end with their parent. ``program``: source
  code as bytes for a digest, without words about it.

Of the project it imports ``arrays``, ``errors``, ``transforms`` and ``units`` only; every package above may import it.
"""
