"""One touch, by closed forms or by the layer solver."""
