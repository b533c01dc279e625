"""The soft pad: meshes, elasticity, contact. Arrays in, arrays out, no storage."""
