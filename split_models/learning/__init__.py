"""How networks learn: frames in, weights and curves out.

Read in this order:

- ``data``: the frames of one part of a split; ``items``: batches of them with what they are to become;
- ``objectives``: the loss of each network; ``augment``, ``contact_region`` and ``relighting``: changed pictures, and
  the VAE objective beyond the paper that uses them;
- ``train_options``, ``training_state`` and ``train``: the loop, which can be killed, resumed and shared;
- ``checkpoint`` and ``curves``: what is written; ``require_finite``: refusals of NaN and infinity;
- ``device``: device, precision and processes; ``held_out_background``: backgrounds that nothing may be learned from.

The room imports ``networks`` and the store's loaders. It knows no recipe and no table.
"""
