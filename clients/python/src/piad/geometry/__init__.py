"""Curves and surfaces as CAD kernels store them, and their form in other packages.

- `curve`, `surface`: what is fitted;
- `basis`: knots and functions of one direction; `net`: homogeneous control points; `ball`: how
  polynomials of the Ball bases become Bézier form;
- `derivative`: derivatives with respect to the parameters;
- `shown`, `picture`: what notebooks show of them;
- `boundary`: boundaries of surfaces, for neighbours that join there;
- `scipy`, `geomdl`, `rhino`, `occ`: the same in other packages, which are imported when asked for.
"""

from .basis import Basis, BasisKind
from .boundary import Boundary
from .curve import Curve
from .surface import Surface

__all__ = ["Basis", "BasisKind", "Boundary", "Curve", "Surface"]
