"""Whether a store is whole, and what of it can be mended.

- ``check``: the one entry; it runs the checks below in the order of their needs and gives findings.
- ``documents``, ``tables``, ``indices``, ``values``, ``payloads``, ``meshes``, ``splits``, ``flags``: one kind of file
  each, against the digests and CRCs that were written with it.
- ``lost_files``: files that are gone, and the command that brings back what lay in them.
- ``pointers``: files of Git LFS that were not fetched. ``stray_sizes``: pictures of another size without a mark.
- ``repair``: what can be mended without inventing data; what cannot is marked, never guessed.
"""
