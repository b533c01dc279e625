"""HDF5 files of one's own: arrays with times beside them, and a mapping that says which is what.

- ``arrays``: which arrays a file holds, and which of them are times;
- ``signals``: a mapped signal from one array, from columns of it, or from several arrays of a group;
- ``pictures``: mapped cameras, frame by frame in the order of time;
- ``draft``: a mapping to start from, by names and shapes;
- ``hdf5``: the format.
"""
