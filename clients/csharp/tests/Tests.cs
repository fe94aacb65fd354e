// The tests: each method of a group is one. Usage: tests PROGRAM [NAME…]

using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Linq;
using System.Reflection;
using System.Threading.Tasks;
using Newtonsoft.Json.Linq;
using Piad;

public static class Tests
{
    public static readonly double[][] Zigzag = { new[] { 0.0, 0 }, new[] { 1.0, 2 }, new[] { 3.0, 1 }, new[] { 4.0, 3 } };

    private static readonly TimeSpan longest = TimeSpan.FromMinutes(2);

    public static int Main(string[] arguments)
    {
        Server.Program = arguments[0];
        int passed = 0, failed = 0;
        using (var server = new Server())
        {
            foreach (MethodInfo test in Chosen(arguments.Skip(1).ToArray()))
            {
                if (Passes(test, server)) passed += 1;
                else failed += 1;
            }
        }
        Console.WriteLine(passed + " passed, " + failed + " failed");
        return failed == 0 && passed > 0 ? 0 : 1;
    }

    /// <summary>Points of a wave in space.</summary>
    public static double[][] Wave(int count)
    {
        return Enumerable.Range(0, count).Select(i => new[] { i, Math.Sin(i / 3.0), Math.Cos(i / 5.0) }).ToArray();
    }

    /// <summary>Rows of points of a surface.</summary>
    public static double[][][] Hill(int rows, int columns)
    {
        return Enumerable.Range(0, rows)
            .Select(i => Enumerable.Range(0, columns).Select(j => new[] { i, j, Math.Sin(i) * Math.Cos(j) }).ToArray())
            .ToArray();
    }

    /// <summary>A fit that does not end by itself.</summary>
    public static CurveRequest Endless()
    {
        return new CurveRequest(Zigzag) { Tolerance = 0, MaxIterations = 1000000000 };
    }

    public static double[] Flat(double[][] rows)
    {
        return rows.SelectMany(row => row).ToArray();
    }

    public static double[] Flat(double[][][] grid)
    {
        return grid.SelectMany(Flat).ToArray();
    }

    private static IEnumerable<MethodInfo> Chosen(string[] names)
    {
        return new[] { typeof(FitTests), typeof(StreamTests), typeof(BatchTests), typeof(MistakeTests), typeof(BreakTests), typeof(HostTests) }
            .SelectMany(group => group.GetMethods(BindingFlags.Public | BindingFlags.Static | BindingFlags.DeclaredOnly))
            .Where(test => names.Length == 0 || names.Contains(test.Name));
    }

    private static bool Passes(MethodInfo test, Server server)
    {
        var time = Stopwatch.StartNew();
        try
        {
            var run = Task.Run(() => (Task)test.Invoke(null, new object[] { server }));
            if (!run.Wait(longest)) throw new CheckFailed("it takes more than " + longest);
            Console.WriteLine("ok     " + test.Name + " (" + time.ElapsedMilliseconds + " ms)");
            return true;
        }
        catch (Exception error)
        {
            Console.WriteLine("FAILED " + test.Name + ": " + (error is AggregateException ? error.InnerException : error));
            return false;
        }
    }
}

/// <summary>Results of fits.</summary>
public static class FitTests
{
    public static async Task ACurveIsThatOfTheOneRequestFit(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            var request = new CurveRequest(Tests.Zigzag) { Degree = 3, Tolerance = 1e-9, Method = "chebyshev", Name = "2026-11-26T08:00:00Z" };
            FitResult result = await client.FitAsync(request);
            FitResult once = await client.FitOnceAsync(request);
            Check.Equal("converged", result.State, "state");
            Check.That(result.Error.Max <= 1e-9 && result.Error.Rms <= result.Error.Max, "the curve is within its tolerance");
            Check.Equal(result.Curve.ControlPoints.Length + 4, result.Curve.Knots.Length, "number of knots");
            Check.Same(Tests.Flat(once.Curve.ControlPoints), Tests.Flat(result.Curve.ControlPoints), "control points");
            Check.Same(once.Curve.Knots, result.Curve.Knots, "knots");
            Check.Same(new[] { 0, 0.0 }, result.Curve.ControlPoints[0], "first control point");
            Check.Equal(4, result.Parameters[0].Length, "parameters");
            Check.That(result.Curve.Weights == null && result.Surface == null, "it is a polynomial curve");
            Check.Equal("2026-11-26T08:00:00Z", (await client.JobAsync(result.Id)).Name, "name that looks like a date");
        }
    }

    public static async Task Base64AndJsonAreTheSameNumbers(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            PiadJob curve = await client.CreateAsync(new CurveRequest(Tests.Wave(30)) { Weights = Enumerable.Range(0, 30).Select(i => 1 + i % 3 / 2.0).ToArray() });
            PiadJob surface = await client.CreateAsync(new SurfaceRequest(Tests.Hill(6, 5)));
            Check.Same(await NumbersAsync(curve, "json"), await NumbersAsync(curve, "base64"), "numbers of a curve");
            Check.Same(await NumbersAsync(surface, "json"), await NumbersAsync(surface, "base64"), "numbers of a surface");
            double[] exact = await NumbersAsync(curve, "base64"), rounded = await NumbersAsync(curve, "base64_f32");
            Check.Equal(exact.Length, rounded.Length, "count of numbers with 32 bits");
            Check.That(exact.Zip(rounded, (a, b) => Math.Abs(a - b) <= 1e-6 * Math.Max(1, Math.Abs(a))).All(near => near), "32 bits are near 64");
        }
    }

    public static async Task RequestsKeepAllDigits(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            var points = new[] { new[] { 0.1 + 0.2, 1.0 / 3 }, new[] { Math.PI, -4.35e-300 }, new[] { 5.000000000000001, 1e22 } };
            PiadJob job = await client.CreateAsync(new CurveRequest(points) { Parameters = "uniform", Degree = 2 });
            var input = (JArray)(await job.InputAsync())["curve"]["points"];
            Check.Same(Tests.Flat(points), input.SelectMany(point => point).Select(number => (double)number), "points");
        }
    }

    public static async Task RationalFitsHaveWeights(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            double[] weights = { 1, 2, 0.5, 1 };
            foreach (string rational in new[] { "homogeneous", "fixed" })
            {
                var request = new CurveRequest(Tests.Zigzag) { Weights = weights, Rational = rational, Tolerance = 1e-6 };
                FittedCurve curve = (await client.FitAsync(request)).Curve;
                Check.Equal(curve.ControlPoints.Length, curve.Weights.Length, rational + " weights of a curve");
                Check.That(curve.Weights.Distinct().Count() > 1, rational + " weights differ");
                FitIteration last = await (await client.CreateAsync(request)).IterationAsync();
                Check.Same(curve.Weights, last.Curve.Weights, rational + " weights of the last iteration");
            }
            double[][] rows = Enumerable.Range(0, 5).Select(i => Enumerable.Range(0, 4).Select(j => (1 + i / 4.0) * (1 + j / 8.0)).ToArray()).ToArray();
            FittedSurface moving = (await client.FitAsync(new SurfaceRequest(Tests.Hill(5, 4)) { Weights = rows })).Surface;
            Check.Same(moving.ControlPoints.Select(row => row.Length), moving.Weights.Select(row => row.Length), "weights of a surface");
        }
    }

    public static async Task FixedWeightsOfASurfaceAreProducts(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            JObject request = new SurfaceRequest(Tests.Hill(5, 4)) { Rational = "fixed" }.ToJson();
            request["surface"]["weights"] = new JObject { { "u", new JArray(1, 2, 3, 2, 1) }, { "v", new JArray(1, 0.5, 0.5, 1) } };
            FittedSurface surface = (await client.FitAsync(request)).Surface;
            double[][] weights = surface.Weights;
            Check.Equal(surface.ControlPoints.Length, weights.Length, "rows of weights");
            Check.Near(weights[0][0] * weights[3][1], weights[3][0] * weights[0][1], 1e-12, "products");
            Check.That(weights.SelectMany(row => row).Distinct().Count() > 2, "weights differ");
        }
    }

    public static async Task ClosedCurvesRepeatTheirFirstControlPoints(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            double[][] ring = { new[] { 1.0, 0 }, new[] { 0, 1.0 }, new[] { -1.0, 0 }, new[] { 0, -1.0 } };
            FittedCurve curve = (await client.FitAsync(new CurveRequest(ring) { Closed = true })).Curve;
            Check.That(curve.Closed, "the curve is closed");
            Check.Same(Tests.Flat(curve.ControlPoints.Take(3).ToArray()), Tests.Flat(curve.ControlPoints.Skip(4).ToArray()), "repeated control points");
        }
    }

    public static async Task SurfacesHaveADegreeInEachDirection(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            FitResult result = await client.FitAsync(new SurfaceRequest(Tests.Hill(7, 6)) { DegreeU = 3, DegreeV = 2, Tolerance = 1e-8 });
            FittedSurface surface = result.Surface;
            Check.Equal(3, surface.DegreeU, "degree in u");
            Check.Equal(2, surface.DegreeV, "degree in v");
            Check.Equal(surface.ControlPoints.Length + 4, surface.KnotsU.Length, "knots in u");
            Check.Equal(surface.ControlPoints[0].Length + 3, surface.KnotsV.Length, "knots in v");
            Check.Same(new[] { 7, 6 }, result.Parameters.Select(line => line.Length), "parameters");
            Check.Equal(2, result.Error.At.Length, "row and column of the worst point");
        }
    }

    public static async Task PointsOfLeastSquaresMayBeMissing(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            double[][][] points = Tests.Hill(8, 8);
            points[3][4] = null;
            JObject method = new JObject { { "kind", "least_squares" }, { "control_points", 5 } };
            FitResult result = await client.FitAsync(new SurfaceRequest(points) { Method = method });
            Check.Same(new[] { 5, 5 }, new[] { result.Surface.ControlPoints.Length, result.Surface.ControlPoints[0].Length }, "control points");
        }
    }

    public static async Task ScatteredPointsMakeASurface(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            double[][] cloud = Enumerable.Range(0, 70).Select(i => new[] { i % 7, i * i % 5, (i % 7) * (i * i % 5) / 10.0 }).ToArray();
            var method = new JObject { { "kind", "least_squares" }, { "control_points", new JObject { { "u", 4 }, { "v", 2 } } }, { "variant", "direct" } };
            var request = new SurfaceRequest(cloud) { DegreeU = 3, DegreeV = 1, Method = method, Parameters = new JObject { { "project", "xy" } } };
            FitResult result = await client.FitAsync(request);
            Check.That(result.Error.Max < 1, "the surface is near its points");
            Check.Equal(4, result.Surface.ControlPoints.Length, "rows of control points");
        }
    }

    public static async Task TrimmedSurfacesHaveTheOutlineOfTheirData(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            double[][] ring = Enumerable.Range(0, 961)
                .Select(i => new[] { i % 31 / 15.0 - 1, i / 31 / 15.0 - 1 })
                .Where(p => p[0] * p[0] + p[1] * p[1] > 0.16 && p[0] * p[0] + p[1] * p[1] < 1)
                .Select(p => new[] { p[0], p[1], p[0] * p[1] })
                .ToArray();
            var method = new JObject { { "kind", "least_squares" }, { "control_points", 6 } };
            var request = new SurfaceRequest(ring) { Method = method, Parameters = new JObject { { "project", "xy" } }, Trim = true };
            Trim trim = (await client.FitAsync(request)).Trim;
            Check.Equal(2, trim.Loops.Length, "loops");
            Check.Equal(1, trim.Faces.Length, "pieces");
            Check.Equal(1, trim.Faces[0][1], "the hole");
            Check.That(trim.Area > 2 && trim.Area < 4, "the area is that of the ring");
            Check.Equal(trim.Loops[0].ControlPoints.Length + 4, trim.Loops[0].Knots.Length, "knots of a loop");
            Check.That((await client.FitAsync(new SurfaceRequest(Tests.Hill(5, 4)))).Trim == null, "other surfaces have none");
        }
    }

    public static async Task BallBasesHaveNoKnots(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            FittedCurve curve = (await client.FitAsync(new CurveRequest(Tests.Zigzag) { Basis = "said_ball", Method = "direct" })).Curve;
            Check.Equal("said_ball", curve.Basis, "basis");
            Check.That(curve.Knots == null, "there are no knots");
        }
    }

    public static async Task JobsAreListedFollowedAndForgotten(Server server)
    {
        using (var own = new Server())
        using (var client = new PiadClient(own.Url))
        {
            PiadJob first = await client.CreateAsync(new CurveRequest(Tests.Zigzag) { Name = "first" });
            PiadJob second = await client.CreateAsync(new CurveRequest(Tests.Zigzag) { Name = "second" });
            await first.WaitAsync();
            await second.WaitAsync();
            Check.That(first.Ended && first.Progress == 1 && first.Iteration > 0 && first.Error.Max < 1e-4, "the job has ended");
            Check.Same(new[] { "second", "first" }, (await client.JobsAsync("converged")).Select(job => job.Name), "jobs");
            Check.Same(new[] { "second" }, (await client.JobsAsync(most: 1)).Select(job => job.Name), "the newest job");
            Check.Equal(0, (await client.JobsAsync("failed")).Count, "failed jobs");
            await first.DeleteAsync();
            ApiException gone = await Check.ThrowsAsync<ApiException>(client.JobAsync(first.Id));
            Check.Equal("/problems/unknown-job", gone.Type, "a deleted job");
        }
    }

    public static async Task AllPagesOfTheListAreAskedFor(Server server)
    {
        using (var own = new Server())
        {
            var relay = new Relay((request, number) => null);
            using (var client = new PiadClient(own.Url, new PiadOptions { HttpMessageHandler = new Smaller(relay) }))
            {
                for (int i = 0; i < 5; i++) await client.CreateAsync(new CurveRequest(Tests.Zigzag) { Name = i.ToString() });
                Check.Same(new[] { "4", "3", "2", "1", "0" }, (await client.JobsAsync()).Select(job => job.Name), "jobs of three pages");
                Check.Equal(3, relay.Requests.Count(request => request == "GET /v1/jobs"), "pages");
            }
        }
    }

    public static async Task AnEditStartsFromItsParent(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            PiadJob job = await client.CreateAsync(new CurveRequest(Tests.Wave(20)));
            await job.WaitAsync();
            var local = new JObject { { "kind", "local" }, { "indices", new JArray(8, 9, 10) } };
            PiadJob edit = await job.EditAsync(new EditRequest { Method = local, Name = "moved" }.Move(9, new[] { 9, 2.0, 0 }));
            Check.Equal(job.Id, edit.Parent, "parent");
            FittedCurve before = (await job.ResultAsync()).Curve, after = (await edit.ResultAsync()).Curve;
            Check.Same(before.Knots, after.Knots, "knots");
            int moved = before.ControlPoints.Zip(after.ControlPoints, (a, b) => a.SequenceEqual(b) ? 0 : 1).Sum();
            Check.Equal(3, moved, "control points that have moved");
        }
    }

    public static async Task FilesHaveANameAndAType(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            PiadJob job = await client.CreateAsync(new CurveRequest(Tests.Wave(10)) { Name = "wave" });
            await job.WaitAsync();
            FitFile step = await job.FileAsync("step", units: "in");
            Check.Equal("model/step", step.MediaType, "media type");
            Check.That(step.Name.StartsWith("wave") && step.Name.EndsWith(".step"), "the file is named after the job: " + step.Name);
            string text = System.Text.Encoding.UTF8.GetString(step.Bytes);
            Check.That(text.StartsWith("ISO-10303-21;") && text.Contains("INCH"), "it is a STEP file in inches");
            FitFile table = await job.FileAsync("csv", iteration: 0, samples: "25");
            Check.That(System.Text.Encoding.UTF8.GetString(table.Bytes).Trim().Split('\n').Length >= 25, "the table has 25 samples");
        }
    }

    public static async Task TheDeviationIsOfTheGeometry(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            PiadJob job = await client.CreateAsync(new CurveRequest(Tests.Wave(25)) { Tolerance = 1e-3 });
            await job.WaitAsync();
            Deviation deviation = await job.DeviationAsync(list: true);
            Check.That(deviation.Max <= job.Error.Max && deviation.Rms <= deviation.Max, "distances to the nearest points are smaller");
            Check.That(deviation.Percentile(50) <= deviation.Percentile(95), "percentiles grow");
            Check.Equal(25, ((JArray)deviation.Json["distances"]).Count, "distances");
            Check.That((await job.DeviationAsync(iteration: 0)).Max > deviation.Max, "iteration 0 is further away");
        }
    }

    /// <summary>Requests pages of two jobs.</summary>
    private sealed class Smaller : System.Net.Http.DelegatingHandler
    {
        public Smaller(System.Net.Http.HttpMessageHandler inner) : base(inner) { }

        protected override Task<System.Net.Http.HttpResponseMessage> SendAsync(System.Net.Http.HttpRequestMessage request, System.Threading.CancellationToken cancellation)
        {
            request.RequestUri = new Uri(request.RequestUri.ToString().Replace("limit=1000", "limit=2"));
            return base.SendAsync(request, cancellation);
        }
    }

    private static async Task<double[]> NumbersAsync(PiadJob job, string encoding)
    {
        var numbers = new List<double>();
        await job.WatchAsync(iteration =>
        {
            if (iteration.Curve != null) numbers.AddRange(Tests.Flat(iteration.Curve.ControlPoints).Concat(iteration.Curve.Weights).Concat(iteration.Curve.Knots));
            else numbers.AddRange(Tests.Flat(iteration.Surface.ControlPoints).Concat(iteration.Surface.KnotsU).Concat(iteration.Surface.KnotsV));
        }, new WatchOptions { Encoding = encoding });
        Check.That(numbers.Count > 100, "there are numbers");
        return numbers.ToArray();
    }
}
