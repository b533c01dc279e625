"""Pictures of one sensor in the style of another, for single pictures, for training batches and for whole stores.

Read in this order:

- ``pixels``: methods that compute on pixels, which a learned method has to beat;
- ``latent_transfer``, ``adaptive_instance_norm`` and ``adain_transfer``: methods that use an image VAE;
- ``methods``: finds any method by name, and lists those that need an image VAE; ``pixels`` lists the others;
- ``method_choice``: the method that suits a store's touches, and how much of a touch a method keeps;
- ``transfer_store``, ``transfer_take`` and ``transfer_picture``: a store whose trajectories name their parents;
  ``transfer_tasks``: its recordings as tasks of a scheduler;
- ``fine_tune``: an image VAE that learns another sensor; ``style_augmentation``: transfer inside a training batch;
- ``latent_vectors``: vectors by which the pictures of sensors are compared. ``picture_size``: pictures of another size.

The room imports ``networks`` and ``learning``. It takes weights from a file and knows no recipe.
"""
