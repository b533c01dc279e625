"""MuJoCo's own soft body as a second engine, for comparison."""
