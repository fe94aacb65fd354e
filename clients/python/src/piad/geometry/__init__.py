"""Curves and surfaces as CAD kernels store them, and conversions to other packages.

- `curve`, `surface`: the fitted geometry;
- `basis`: knots and functions of one direction; `net`: homogeneous control points; `ball`: conversion of the Ball bases
  to Bézier form;
- `derivative`: derivatives with respect to the parameters;
- `shown`, `picture`: what notebooks show of them;
- `boundary`: boundaries of surfaces, for neighbours that join there;
- `scipy`, `geomdl`, `rhino`, `occ`: conversions to other packages, which are imported when needed.
"""

from .basis import Basis, BasisKind
from .boundary import Boundary
from .curve import Curve
from .surface import Surface

__all__ = ["Basis", "BasisKind", "Boundary", "Curve", "Surface"]
