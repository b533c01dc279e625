"""A recipe, its data and its networks: what is trained on what, and where the results are kept.

Read in this order:

- ``recipe`` and ``recipe_defaults``: the document, and the paper's protocol for what it leaves out;
- ``prepare`` and ``recipe_data``: the store of a recipe, made first where it is a simulated world, and its frames;
- ``kept_models``: networks in a folder, each trained once and named by what shaped it;
- ``image_vae_recipe`` and ``part_latents``: the image VAE as a recipe describes it; latent vectors of a whole part;
- ``recipe_run``: all of these together, the object that methods and tables work with.

The room imports ``networks`` and ``learning``, and the rig, ingest and replay to make a world. It knows no table.
"""
