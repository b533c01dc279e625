"""How does a bonded layer answer a ball or a punch, without a gel engine?

- ``on_layer``: what the closed forms have in common.
- ``ball_on_layer``: a ball, and the friction of one spring.
- ``punch_on_layer``: a flat punch.

They serve previews, examples and tests, 5 to 20 % off at 1 mm depth. A diagnosis uses the gel engine.
"""
