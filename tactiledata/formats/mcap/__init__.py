"""The MCAP format: ROS 2, ROS 1, protobuf and JSON messages, whole or damaged.

- ``mcap``: the member of the family; start here.
- ``bags``: which files make one recording. ``layout``, ``records``, ``chunks``: bytes to records, CRCs checked,
  damage said.
- ``survey``: what a file says of itself. ``playback``: its messages, handed to whoever wants them.
- ``roles``: which topic is what. ``readers``, ``reading``: from a role to numbers. ``decode``, ``cdr``: payloads to
  messages. ``message_fields``: paths to the fields of a message. ``undecoded``: why a message
  could not be decoded, in words.
- ``collect``, ``images``, ``transform_tree``, ``describe``: signals, pictures, poses and the description.
- ``tally``, ``contents``, ``likely_fields``, ``unread_topics``, ``mapping_draft``: ``inspect``, and a mapping to
  start from; ``joint_draft``: one for several recordings. ``passed_over``: topics that could be a stream that is
  lacking, and are not read.
"""
