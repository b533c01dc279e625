"""One touch: which wrench, sliding and surface a gel gives when an indenter follows a path.

Read `contact` first (what every form of contact takes and gives) and `footprint` (the turned indenter over the gel).
`closed_form` holds the laws, `analytic` plays a touch by them and `membrane` draws its surface. `by_layer` plays the
same touch by the layer solver and `layer_picture` draws that surface. `gel_cap` and `inclined` are for domed gels.

The room knows no hidden effects and no instruments: gel frame in, wrench on the indenter out.
"""
