"""Mesh: of which cells a pad consists, and which part of its surface can be touched.

Read in this order:

- ``pad``: the mesh itself, nodes, cells, base and outer surface in the gel frame;
- ``structured_pad``: pads of hexahedra from a sensor's gel geometry (`GelGeometry` in ``sensors.base``);
- ``mesh_file``, ``mesh_frame``, ``tetrahedra``: pads of ten-node tetrahedra from a user's volume mesh;
- ``cells``: shape functions and quadrature of the cells; ``surface``: patches that carry contact forces.

The room holds geometry only: it knows neither the material nor any indenter.
"""
