// A Grasshopper component that fits a curve without blocking the definition: the fit runs on the
// server, its iterations are shown as they arrive, at most 20 times a second, and new inputs cancel
// the previous fit.
//
// Compile it with Piad.cs and the symbol PIAD_RHINO into a .gha (see README.md). It is tested
// against stubs of Grasshopper: starting, cancelling, showing and failing; parameters, icons and
// the user interface thread are not tested.

using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;
using Grasshopper.Kernel;
using Piad;
using Rhino.Geometry;

namespace PiadExamples
{
    /// <summary>Points in, curve out.</summary>
    public class GrasshopperFit : GH_Component
    {
        private const int MillisecondsBetweenPictures = 50;

        // State shared by the fit and the user interface thread.
        private readonly object gate = new object();
        private Fit fit;

        /// <summary>Called by Grasshopper.</summary>
        public GrasshopperFit() : base("Piad fit", "Fit", "Fits a curve through points, iteration by iteration", "Curve", "Spline") { }

        /// <summary>The id of the component, which never changes.</summary>
        public override Guid ComponentGuid { get { return new Guid("6d8f2a0c-9c0e-4f4b-8a4e-3c2c6f6f51d7"); } }

        /// <summary>Ends the fit with the component.</summary>
        public override void RemovedFromDocument(GH_Document document)
        {
            Start(null);
            base.RemovedFromDocument(document);
        }

        /// <summary>Ends the fit with the document.</summary>
        public override void DocumentContextChanged(GH_Document document, GH_DocumentContext context)
        {
            if (context == GH_DocumentContext.Close || context == GH_DocumentContext.Unloaded) Start(null);
            base.DocumentContextChanged(document, context);
        }

        /// <summary>The inputs.</summary>
        protected override void RegisterInputParams(GH_InputParamManager pManager)
        {
            pManager.AddPointParameter("Points", "P", "Data points, in order", GH_ParamAccess.list);
            pManager.AddIntegerParameter("Degree", "D", "Degree of the B-spline", GH_ParamAccess.item, 3);
            pManager.AddNumberParameter("Tolerance", "T", "Largest allowed distance from a point", GH_ParamAccess.item, 0.001);
            pManager.AddBooleanParameter("Closed", "C", "True if the curve is periodic", GH_ParamAccess.item, false);
            pManager.AddTextParameter("Server", "S", "Address of the server", GH_ParamAccess.item, "http://127.0.0.1:8080");
            pManager.AddTextParameter("Token", "K", "Token of the server, if it asks for one", GH_ParamAccess.item);
            pManager[5].Optional = true;
        }

        /// <summary>The outputs.</summary>
        protected override void RegisterOutputParams(GH_OutputParamManager pManager)
        {
            pManager.AddCurveParameter("Curve", "C", "The curve of the newest iteration", GH_ParamAccess.item);
            pManager.AddIntegerParameter("Iteration", "N", "Its number", GH_ParamAccess.item);
            pManager.AddNumberParameter("Distance", "E", "The largest distance from a data point", GH_ParamAccess.item);
            pManager.AddTextParameter("State", "S", "running, converged, exhausted, stalled, failed or cancelled", GH_ParamAccess.item);
        }

        /// <summary>Starts a fit for new inputs and outputs the latest state. Never
        /// blocks.</summary>
        protected override void SolveInstance(IGH_DataAccess DA)
        {
            if (DA.Iteration > 0)
            {
                // A component has one fit: a second list would cancel that of the first one
                // repeatedly.
                AddRuntimeMessage(GH_RuntimeMessageLevel.Warning, "only the first list of points is fitted: use a component for each");
                return;
            }
            Inputs inputs = Read(DA);
            if (inputs == null)
            {
                Start(null);
                return;
            }
            Fit current = Current(inputs);
            FitIteration iteration;
            string state, failure;
            lock (gate)
            {
                iteration = current.Newest;
                state = current.State;
                failure = current.Failure;
            }
            Message = state;
            if (failure != null) AddRuntimeMessage(GH_RuntimeMessageLevel.Error, failure);
            DA.SetData(3, state);
            if (iteration == null) return;
            DA.SetData(0, iteration.Curve.ToRhino());
            DA.SetData(1, (int)iteration.Number);
            DA.SetData(2, iteration.Error.Max);
        }

        private static Inputs Read(IGH_DataAccess DA)
        {
            var points = new List<Point3d>();
            var inputs = new Inputs { Degree = 3, Tolerance = 0.001, Server = "http://127.0.0.1:8080" };
            if (!DA.GetDataList(0, points)) return null;
            DA.GetData(1, ref inputs.Degree);
            DA.GetData(2, ref inputs.Tolerance);
            DA.GetData(3, ref inputs.Closed);
            DA.GetData(4, ref inputs.Server);
            DA.GetData(5, ref inputs.Token);
            inputs.Points = points.Select(point => new[] { point.X, point.Y, point.Z }).ToArray();
            return inputs;
        }

        private Fit Current(Inputs inputs)
        {
            lock (gate)
            {
                if (fit != null && fit.Inputs.IsSame(inputs)) return fit;
            }
            var started = new Fit { Inputs = inputs };
            Start(started);
            return started;
        }

        // Cancels the previous fit.
        private void Start(Fit next)
        {
            Fit last;
            lock (gate)
            {
                last = fit;
                fit = next;
            }
            if (last != null) last.Cancellation.Cancel();
            if (next != null) Task.Run(() => RunAsync(next));
        }

        private async Task RunAsync(Fit run)
        {
            string state = "failed", failure = null;
            try
            {
                using (var client = new PiadClient(run.Inputs.Server, new PiadOptions { Token = run.Inputs.Token }))
                {
                    var request = new CurveRequest(run.Inputs.Points)
                    {
                        Degree = run.Inputs.Degree, Tolerance = run.Inputs.Tolerance, Closed = run.Inputs.Closed,
                    };
                    // The server skips iterations that arrive faster than they are shown, and an
                    // abandoned fit ends with its connection.
                    var options = new WatchOptions { View = "control_points", Pace = "latest", CancelOnDisconnect = true };
                    var sincePicture = Stopwatch.StartNew();
                    JobEnd end = await client.CreateStream(request, options).ForEachAsync(async iteration =>
                    {
                        lock (gate) run.Newest = iteration;
                        Show(run);
                        int rest = MillisecondsBetweenPictures - (int)sincePicture.ElapsedMilliseconds;
                        if (rest > 0) await Task.Delay(rest, run.Cancellation.Token).ConfigureAwait(false);
                        sincePicture.Restart();
                    }, run.Cancellation.Token).ConfigureAwait(false);
                    state = end.State;
                    if (state == "failed") failure = end.Detail;
                }
            }
            catch (OperationCanceledException)
            {
                return;
            }
            catch (Exception error)
            {
                failure = error.Message;
            }
            lock (gate)
            {
                run.State = state;
                run.Failure = failure;
            }
            Show(run);
        }

        // Expires the solution on the user interface thread, if the fit is still current.
        private void Show(Fit run)
        {
            Rhino.RhinoApp.InvokeOnUiThread((Action)(() =>
            {
                lock (gate)
                {
                    if (fit != run) return;
                }
                GH_Document document = OnPingDocument();
                if (document != null) document.ScheduleSolution(1, ignored => ExpireSolution(false));
            }));
        }

        private sealed class Fit
        {
            public readonly CancellationTokenSource Cancellation = new CancellationTokenSource();
            public Inputs Inputs;
            public FitIteration Newest;
            public string State = "running";
            public string Failure;
        }

        private sealed class Inputs
        {
            public double[][] Points;
            public int Degree;
            public double Tolerance;
            public bool Closed;
            public string Server;
            public string Token;

            public bool IsSame(Inputs other)
            {
                return Degree == other.Degree && Tolerance.Equals(other.Tolerance) && Closed == other.Closed && Server == other.Server
                    && Token == other.Token && Points.Length == other.Points.Length
                    && Points.Zip(other.Points, (a, b) => a.SequenceEqual(b)).All(same => same);
            }
        }
    }
}
