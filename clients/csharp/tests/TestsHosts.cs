// The adapters and the Grasshopper component with stubs of their hosts: checks the values passed to
// the hosts.

using System;
using System.Collections.Concurrent;
using System.Collections.Generic;
using System.Diagnostics;
using System.IO;
using System.Linq;
using System.Threading.Tasks;
using Grasshopper.Kernel;
using Piad;
using PiadExamples;
using Rhino.Geometry;

/// <summary>Values passed to hosts.</summary>
public static class HostTests
{
    public static async Task RhinoGetsKnotsWithoutTheFirstAndTheLast(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            FittedCurve curve = (await client.FitAsync(new CurveRequest(Tests.Zigzag) { Weights = new[] { 1, 2, 0.5, 1 } })).Curve;
            NurbsCurve rhino = curve.ToRhino();
            Check.Same(curve.Knots.Skip(1).Take(curve.Knots.Length - 2), rhino.Knots, "knots");
            Check.Equal(4, rhino.Order, "order");
            Check.Same(curve.Weights, rhino.Points.StoredWeights, "weights");
            Check.Same(curve.ControlPoints.SelectMany(point => new[] { point[0], point[1], 0 }), rhino.Points.Stored.SelectMany(point => new[] { point.X, point.Y, point.Z }), "points");
            FittedSurface surface = (await client.FitAsync(new SurfaceRequest(Tests.Hill(6, 5)) { DegreeU = 3, DegreeV = 2 })).Surface;
            NurbsSurface patch = surface.ToRhino();
            Check.Same(surface.KnotsV.Skip(1).Take(surface.KnotsV.Length - 2), patch.KnotsV, "knots in v");
            Check.Equal(surface.ControlPoints[2][3][2], patch.Points.Stored[Tuple.Create(2, 3)].Item1.Z, "z of a control point");
            Check.Equal(1.0, patch.Points.Stored[Tuple.Create(2, 3)].Item2, "weight of a control point");
        }
    }

    public static async Task RevitGetsFeet(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            FittedCurve curve = (await client.FitAsync(new CurveRequest(Tests.Wave(10)))).Curve;
            var revit = (Autodesk.Revit.DB.NurbSpline)curve.ToRevit(1 / 304.8);
            Check.Same(curve.Knots, revit.StoredKnots, "knots");
            Check.Near(curve.ControlPoints[5][0] / 304.8, revit.StoredPoints[5].X, 1e-15, "x of a control point");
            FittedSurface surface = (await client.FitAsync(new SurfaceRequest(Tests.Hill(6, 5)))).Surface;
            Autodesk.Revit.DB.BRepBuilderSurfaceGeometry patch = surface.ToRevit();
            int columns = surface.ControlPoints[0].Length;
            Check.Equal(surface.ControlPoints[2][3][2], patch.StoredPoints[2 * columns + 3].Z, "z of a control point");
            Check.Equal(surface.ControlPoints.Length * columns, patch.StoredWeights.Count, "weights");
        }
    }

    public static async Task HostsHaveNoBallBases(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            FittedCurve curve = (await client.FitAsync(new CurveRequest(Tests.Zigzag) { Basis = "wang_ball", Method = "direct" })).Curve;
            Check.That(Check.Throws<NotSupportedException>(() => curve.ToRhino()).Message.Contains("wang_ball"), "the basis is named");
            Check.Throws<NotSupportedException>(() => curve.ToRevit());
        }
    }

    public static async Task TheComponentShowsIterationsAndTheEnd(Server server)
    {
        var component = new GrasshopperFit();
        component.Register(new GH_Component.GH_InputParamManager());
        var outputs = new ConcurrentQueue<Data>();
        var data = new Data { Server = server.Url, Points = Tests.Wave(300), Tolerance = 1e-11 };
        component.Expired += () => outputs.Enqueue(Solve(component, data));
        var time = Stopwatch.StartNew();
        Solve(component, data);
        Check.That(time.ElapsedMilliseconds < 2000, "a solution does not wait");
        Data last = await LastAsync(outputs);
        Check.Equal("converged", last.Out[3], "state");
        Check.That(last.Out[0] is NurbsCurve && (int)last.Out[1] > 0 && (double)last.Out[2] <= 1e-11, "the curve is that of the last iteration");
        Check.That(outputs.Count <= 3 + time.Elapsed.TotalSeconds * 20, outputs.Count + " pictures in " + time.Elapsed);
    }

    public static async Task NewInputsCancelTheFitBefore(Server server)
    {
        using (var own = new Server())
        using (var client = new PiadClient(own.Url))
        {
            var component = new GrasshopperFit();
            var data = new Data { Server = own.Url, Points = Tests.Zigzag.Select(point => new[] { point[0], point[1], 0 }).ToArray(), Tolerance = 1e-300 };
            var outputs = new ConcurrentQueue<Data>();
            component.Expired += () => outputs.Enqueue(Solve(component, data));
            Solve(component, data);
            while (!outputs.Any(output => output.Out.ContainsKey(0))) await Task.Delay(10);
            data = new Data { Server = own.Url, Points = Tests.Wave(10), Tolerance = 1e-6 };
            Solve(component, data);
            Data last = await LastAsync(outputs);
            Check.Equal("converged", last.Out[3], "state of the new fit");
            Check.Equal(10, (await client.JobsAsync("converged")).Single().Json.Value<int>("points"), "points of the new fit");
            var time = Stopwatch.StartNew();
            while ((await client.JobsAsync("running")).Count > 0 && time.Elapsed < TimeSpan.FromSeconds(20)) await Task.Delay(50);
            Check.Equal(0, (await client.JobsAsync("running")).Count, "abandoned fits");
        }
    }

    public static async Task TheComponentSaysWhatIsWrong(Server server)
    {
        var component = new GrasshopperFit();
        var outputs = new ConcurrentQueue<Data>();
        var data = new Data { Server = server.Url, Points = new[] { new[] { 0.0, 0, 0 }, new[] { 0.0, 0, 0 } }, Tolerance = 1e-6 };
        component.Expired += () => outputs.Enqueue(Solve(component, data));
        Solve(component, data);
        Check.Equal("failed", (await LastAsync(outputs)).Out[3], "state");
        Check.That(component.Messages.Single().StartsWith("Error: 422"), component.Messages.Single());
    }

    public static async Task TheProgramOfTheReadmeRuns(Server server)
    {
        string folder = Path.Combine(Path.GetTempPath(), "piad-csharp-" + Guid.NewGuid());
        Directory.CreateDirectory(folder);
        try
        {
            string program = Path.Combine(AppDomain.CurrentDomain.BaseDirectory, "readme.exe");
            var information = new ProcessStartInfo("mono", program) { UseShellExecute = false, RedirectStandardOutput = true, WorkingDirectory = folder };
            information.EnvironmentVariables["PIAD_URL"] = server.Url;
            using (Process process = Process.Start(information))
            {
                string output = await process.StandardOutput.ReadToEndAsync();
                process.WaitForExit();
                Check.Equal(0, process.ExitCode, "exit code");
                Check.Equal(2, output.Split(new[] { "converged" }, StringSplitOptions.None).Length - 1, "fits that converge in\n" + output);
                Check.That(File.ReadAllText(Path.Combine(folder, "ring.step")).StartsWith("ISO-10303-21;"), "it writes a file");
            }
        }
        finally
        {
            Directory.Delete(folder, true);
        }
    }

    private static async Task<Data> LastAsync(ConcurrentQueue<Data> outputs)
    {
        for (;;)
        {
            Data last = outputs.LastOrDefault(output => output.Out.ContainsKey(3) && (string)output.Out[3] != "running");
            if (last != null) return last;
            await Task.Delay(10);
        }
    }

    private static Data Solve(GH_Component component, Data inputs)
    {
        var data = new Data { Server = inputs.Server, Points = inputs.Points, Tolerance = inputs.Tolerance };
        component.Solve(data);
        return data;
    }

    private sealed class Data : IGH_DataAccess
    {
        public string Server;
        public double[][] Points;
        public double Tolerance;
        public readonly Dictionary<int, object> Out = new Dictionary<int, object>();

        public int Iteration { get { return 0; } }

        public bool GetData<T>(int index, ref T destination)
        {
            if (index == 2) destination = (T)(object)Tolerance;
            if (index == 4) destination = (T)(object)Server;
            return index == 2 || index == 4;
        }

        public bool GetDataList<T>(int index, List<T> list)
        {
            list.AddRange(Points.Select(point => (T)(object)new Point3d(point[0], point[1], point[2])));
            return true;
        }

        public bool SetData(int paramIndex, object data)
        {
            Out[paramIndex] = data;
            return true;
        }
    }
}
