// Stubs: signatures of RhinoCommon 6 and later that the adapter and the example call, to compile
// these without Rhino. They store their arguments and compute nothing.

using System;
using System.Collections.Generic;

namespace Rhino
{
    public static class RhinoApp
    {
        // Only in the stub: the lock of the user interface thread.
        public static readonly object Window = new object();

        public static void InvokeOnUiThread(Delegate method, params object[] args)
        {
            lock (Window) method.DynamicInvoke(args);
        }
    }
}

namespace Rhino.Geometry
{
    public struct Point3d
    {
        public Point3d(double x, double y, double z) : this()
        {
            X = x;
            Y = y;
            Z = z;
        }

        public double X { get; set; }
        public double Y { get; set; }
        public double Z { get; set; }
    }

    public abstract class GeometryBase { }

    public abstract class Curve : GeometryBase { }

    public abstract class Surface : GeometryBase { }

    public class NurbsCurve : Curve
    {
        public NurbsCurve(int dimension, bool rational, int order, int pointCount)
        {
            IsRational = rational;
            Order = order;
            Points = new Collections.NurbsCurvePointList(pointCount);
            Knots = new Collections.NurbsCurveKnotList(order + pointCount - 2);
        }

        public bool IsRational { get; private set; }
        public int Order { get; private set; }
        public Collections.NurbsCurveKnotList Knots { get; private set; }
        public Collections.NurbsCurvePointList Points { get; private set; }
    }

    public class NurbsSurface : Surface
    {
        public Collections.NurbsSurfaceKnotList KnotsU { get; private set; }
        public Collections.NurbsSurfaceKnotList KnotsV { get; private set; }
        public Collections.NurbsSurfacePointList Points { get; private set; }

        public static NurbsSurface Create(int dimension, bool isRational, int order0, int order1, int controlPointCount0, int controlPointCount1)
        {
            return new NurbsSurface
            {
                KnotsU = new Collections.NurbsSurfaceKnotList(order0 + controlPointCount0 - 2),
                KnotsV = new Collections.NurbsSurfaceKnotList(order1 + controlPointCount1 - 2),
                Points = new Collections.NurbsSurfacePointList(),
            };
        }
    }
}

namespace Rhino.Geometry.Collections
{
    public class NurbsCurveKnotList : List<double>
    {
        internal NurbsCurveKnotList(int count) : base(new double[count]) { }
    }

    public class NurbsSurfaceKnotList : List<double>
    {
        internal NurbsSurfaceKnotList(int count) : base(new double[count]) { }
    }

    public class NurbsCurvePointList
    {
        public readonly Point3d[] Stored;
        public readonly double[] StoredWeights;

        internal NurbsCurvePointList(int count)
        {
            Stored = new Point3d[count];
            StoredWeights = new double[count];
        }

        public bool SetPoint(int index, Point3d point, double weight)
        {
            Stored[index] = point;
            StoredWeights[index] = weight;
            return true;
        }
    }

    public class NurbsSurfacePointList
    {
        public readonly Dictionary<Tuple<int, int>, Tuple<Point3d, double>> Stored = new Dictionary<Tuple<int, int>, Tuple<Point3d, double>>();

        public bool SetPoint(int u, int v, Point3d point, double weight)
        {
            Stored[Tuple.Create(u, v)] = Tuple.Create(point, weight);
            return true;
        }
    }
}
