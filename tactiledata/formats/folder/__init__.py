"""The folder log: one folder, one recording, in files that people can read (docs/formats-folder.md).

- ``folder``: the member of the family; start here.
- ``files``: which files belong to a log, none of them outside its folder.
- ``trajectories``: which intervals of the host clock are which touch.
- ``signals``: wrench, poses and joints; rows that do not read are left out and reported.
- ``frames``: the table of pictures and the pictures that it names.
"""
