"""The networks of the SPLIT paper, and latent arithmetic with them.

Read in this order:

- ``network``: what every network offers to a checkpoint; ``network_inputs``: which shapes and types are refused;
- ``perceptron``, ``latent_normal``, ``sparse_map``: the parts that networks share;
- ``image_vae`` and ``learned_backgrounds``: the VAE of pictures, and the sensors it was trained on;
- ``decimation``, ``mesh_graph``, ``mesh_vae``: coarser meshes, their graph Laplacians, the VAE of displacements;
- ``projection``, ``force_head``, ``end_to_end``: from one latent space to the other, to forces, and the direct way;
- ``latent``: encode, subtract the background, project, add a background, decode.

The room imports the gel's mesh and the store's reader, and no other room of `split_models`: nothing here trains.
"""
