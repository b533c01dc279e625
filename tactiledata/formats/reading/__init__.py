"""What several formats read alike.

- ``corpus``, ``intake``: importers of public corpora: folders, nominal clocks, pictures and findings handed over.
- ``csv_cells``, ``csv_tables``: tables from strangers; every faulty row is accounted for.
- ``restricted_pickle``, ``unread_object``, ``pickled_list``, ``npz_members``, ``hdf5_members``: arrays from strangers,
  read without running code.
- ``backgrounds``, ``described``: pictures without contact, trajectories and topics that a description or mapping
  names.
- ``natural_order``, ``links``, ``modality``, ``optitrack``, ``contact_radius``, ``rotation_vectors``,
  ``stream_rate``: one question each.
- ``stream_info``: what `tactiledata inspect` says of a camera or a signal.
"""
