// Stubs: signatures of the API of Revit 2018 and later that the adapter calls.

using System.Collections.Generic;

namespace Autodesk.Revit.DB
{
    public class XYZ
    {
        public XYZ(double x, double y, double z)
        {
            X = x;
            Y = y;
            Z = z;
        }

        public double X { get; private set; }
        public double Y { get; private set; }
        public double Z { get; private set; }
    }

    public class BoundingBoxUV { }

    public abstract class Curve { }

    public class NurbSpline : Curve
    {
        public int StoredDegree;
        public IList<double> StoredKnots;
        public IList<XYZ> StoredPoints;
        public IList<double> StoredWeights;

        public static Curve CreateCurve(int degree, IList<double> knots, IList<XYZ> controlPoints, IList<double> weights)
        {
            return new NurbSpline { StoredDegree = degree, StoredKnots = knots, StoredPoints = controlPoints, StoredWeights = weights };
        }
    }

    public class BRepBuilderSurfaceGeometry
    {
        public IList<double> StoredKnotsU;
        public IList<double> StoredKnotsV;
        public IList<XYZ> StoredPoints;
        public IList<double> StoredWeights;

        public static BRepBuilderSurfaceGeometry CreateNURBSSurface(
            int degreeU, int degreeV, IList<double> knotsU, IList<double> knotsV, IList<XYZ> controlPoints, IList<double> weights,
            bool bReverseOrientation, BoundingBoxUV pSurfaceEnvelope)
        {
            return new BRepBuilderSurfaceGeometry { StoredKnotsU = knotsU, StoredKnotsV = knotsV, StoredPoints = controlPoints, StoredWeights = weights };
        }
    }
}
