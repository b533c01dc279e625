"""Which recordings there are, and what became of them.

- ``discover``: recordings under the paths that a user names.
- ``refused``: recordings and places that cannot be read.
- ``preview``: what ingest would make of a recording and say of it, for `tactiledata inspect`. ``image_facts``: facts of
  its images, in place of the images.
- ``replacing``: which recording of a store a corrected one replaces.
- ``reports``: what became of each recording, for people and for machines.
- ``overview``: what a store holds, gathered for a page. ``first_program``: the program with which to start using
  it.
"""
