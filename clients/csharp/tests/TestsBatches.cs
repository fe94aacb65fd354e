// Many fits in one request.

using System;
using System.Collections.Generic;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;
using Newtonsoft.Json.Linq;
using Piad;

/// <summary>Batches.</summary>
public static class BatchTests
{
    public static async Task ItemsOfABatchAreWhatFitsAre(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            var requests = new FitRequest[]
            {
                new CurveRequest(Tests.Wave(30)) { Name = "wave" },
                new SurfaceRequest(Tests.Hill(6, 5)),
                new JObject { ["curve"] = new JObject { ["points"] = new JArray(new JArray(0, 0), new JArray(1, 1), new JArray(1, 1)) } },
                new CurveRequest(Tests.Zigzag) { Tolerance = 1e-12, MaxIterations = 1 },
            };
            List<BatchItem> items = await AllAsync(client, requests);
            FitResult curve = await client.FitAsync(requests[0]), surface = await client.FitAsync(requests[1]);
            Check.Same(Tests.Flat(curve.Curve.ControlPoints), Tests.Flat(items[0].Result.Curve.ControlPoints), "control points");
            Check.Same(curve.Curve.Knots, items[0].Result.Curve.Knots, "knots");
            Check.Same(Tests.Flat(surface.Surface.ControlPoints), Tests.Flat(items[1].Result.Surface.ControlPoints), "control points of a surface");
            Check.Equal("wave", items[0].Name, "name");
            Check.Equal(curve.Iteration, items[0].Iteration.Value, "iteration");
            Check.Equal(curve.Error.Max, items[0].Error.Max, "error");
            Check.Equal("converged converged failed exhausted", string.Join(" ", items.Select(item => item.State)), "states");
            Check.Equal("/items/2/curve/points/2", items[2].Problem.Pointers[0], "pointer");
            Check.That(items[2].Result == null && items[0].Problem == null, "an item has a result or a problem");
            Check.Equal("/problems/not-converged", items[3].Problem.Type, "type");
            Check.Equal(1L, items[3].Result.Iteration, "the last iteration is there");
        }
    }

    public static async Task ThousandsOfItemsComeInOrder(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            long taken = 0, seen = 0, ahead = 0;
            var items = Enumerable.Range(0, 2000).Select(number =>
            {
                taken += 1;
                return number == 1500 ? (FitRequest)new JObject { ["curve"] = new JObject { ["points"] = new JArray() } } : Wave(number);
            });
            var defaults = new JObject
            {
                ["method"] = new JObject { ["kind"] = "least_squares", ["control_points"] = "auto" },
                ["stop"] = new JObject { ["tolerance"] = 0.01 },
            };
            BatchTotals totals = await client.BatchAsync(items, item =>
            {
                Check.Equal(seen, item.Index, "index");
                seen += 1;
                ahead = Math.Max(ahead, taken - seen);
                if (item.Index == 1500) Check.That(item.Problem.Detail.StartsWith("/items/1500/curve"), item.Problem.Detail);
                else Check.That(item.Result.Curve.ControlPoints.Length < 40, "few control points");
            }, defaults);
            Check.Equal("2000 1999 1", totals.Items + " " + totals.Converged + " " + totals.Failed, "totals");
            Check.That(ahead < 1000, ahead + " items are taken ahead");
            Check.Equal(0L, (await client.BatchAsync(new FitRequest[0], item => { })).Items, "an empty batch");
        }
    }

    public static async Task BatchesGoOnAfterAServerWasKilled(Server server)
    {
        using (var own = new Server())
        using (var client = new PiadClient(own.Url))
        {
            long seen = 0;
            await client.BatchAsync(Enumerable.Range(0, 500).Select(Wave), item =>
            {
                Check.Equal(seen, item.Index, "index");
                seen += 1;
                if (item.Index != 100) return;
                own.Kill();
                own.Start();
            });
            Check.Equal(500L, seen, "items");
        }
    }

    public static async Task BatchesAreRefusedCancelledAndBrokenOff(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            var refused = await Check.ThrowsAsync<ApiException>(AllAsync(client, new FitRequest[] { Wave(0) }, new JObject { ["tolerance"] = 1 }));
            Check.Equal("/defaults/tolerance", refused.Pointers[0], "pointer");
            using (var cancelling = new CancellationTokenSource())
            {
                Task task = client.BatchAsync(Enumerable.Range(0, 500).Select(Wave), item => cancelling.Cancel(), null, cancelling.Token);
                await Check.ThrowsAsync<OperationCanceledException>(task);
            }
            Task thrown = client.BatchAsync(Enumerable.Range(0, 500).Select(Wave), item => { throw new InvalidOperationException("enough"); });
            Check.Equal("enough", (await Check.ThrowsAsync<InvalidOperationException>(thrown)).Message, "message");
            Check.Equal("converged", (await client.FitAsync(Wave(0))).State, "the client can still be used");
        }
    }

    private static CurveRequest Wave(int number)
    {
        var points = Enumerable.Range(0, 50).Select(i => new[] { i / 7.0, Math.Sin(i / 7.0 + number) });
        return new CurveRequest(points.ToArray()) { Name = "wave " + number };
    }

    private static async Task<List<BatchItem>> AllAsync(PiadClient client, IEnumerable<FitRequest> requests, JObject defaults = null)
    {
        var items = new List<BatchItem>();
        await client.BatchAsync(requests, item => items.Add(item), defaults);
        return items;
    }
}
