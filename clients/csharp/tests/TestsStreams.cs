// Streams: content and resumption.

using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.IO;
using System.Linq;
using System.Net.Http;
using System.Threading;
using System.Threading.Tasks;
using Newtonsoft.Json.Linq;
using Piad;

/// <summary>Content of streams.</summary>
public static class StreamTests
{
    public static async Task EachIterationComesOnceAndInOrder(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            var numbers = new List<long>();
            FitIteration last = null;
            FitStream stream = client.CreateStream(new CurveRequest(Tests.Wave(40)) { Tolerance = 1e-9 });
            JobEnd end = await stream.ForEachAsync(iteration =>
            {
                numbers.Add(iteration.Number);
                last = iteration;
            });
            Check.Equal("converged", end.State, "state");
            Check.Same(Enumerable.Range(0, (int)end.Iterations + 1).Select(k => (long)k), numbers, "numbers");
            FitResult result = await (await client.JobAsync(stream.JobId)).ResultAsync();
            Check.Same(Tests.Flat(result.Curve.ControlPoints), Tests.Flat(last.Curve.ControlPoints), "control points of the last");
            Check.That(last.Rate < 1 && last.Predicted >= last.Number && last.Moved > 0, "the last iteration has its rate");
        }
    }

    public static async Task AJobIsWatchedFromAnyIteration(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            PiadJob job = await client.CreateAsync(new CurveRequest(Tests.Wave(40)) { Tolerance = 1e-9 });
            var numbers = new List<long>();
            await job.WatchAsync(iteration => numbers.Add(iteration.Number), new WatchOptions { After = 7 });
            Check.That(job.Ended, "the job has ended with its stream");
            Check.Equal(8, (int)numbers[0], "the first iteration after 7");
            Check.Equal(numbers.Last(), job.Iteration.Value, "the last iteration");
            FitIteration third = await job.IterationAsync(3);
            Check.Equal(3, (int)third.Number, "an iteration");
            Check.Equal(third.Curve.ControlPoints.Length + 4, third.Curve.Knots.Length, "its knots");
        }
    }

    public static async Task OptionsChooseWhatIsShown(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            PiadJob curve = await client.CreateAsync(new CurveRequest(Tests.Wave(40)) { Tolerance = 1e-9 });
            PiadJob surface = await client.CreateAsync(new SurfaceRequest(Tests.Hill(6, 6)));
            FitIteration last = (await ListAsync(curve, new WatchOptions { View = "samples", Samples = "33" })).Last();
            Check.Equal(33, last.Samples.Length, "samples of a curve");
            Check.Equal(33, last.Parameters[0].Length, "parameters of the samples");
            Check.That(last.Curve == null, "samples are no control points");
            last = (await ListAsync(surface, new WatchOptions { View = "samples", Samples = "9x7" })).Last();
            Check.Same(new[] { 9, 7, 3 }, new[] { last.SampleRows.Length, last.SampleRows[0].Length, last.SampleRows[0][0].Length }, "samples of a surface");
            Check.Same(new[] { 9, 7 }, last.Parameters.Select(line => line.Length), "their parameters");
            List<FitIteration> all = await ListAsync(curve, new WatchOptions { View = "errors", Every = 10 });
            Check.That(all.Take(all.Count - 1).All(iteration => iteration.Number % 10 == 0), "every tenth");
            Check.That(all.All(iteration => iteration.Curve == null), "errors are without geometry");
            all = await ListAsync(curve, new WatchOptions { Milestones = new[] { 0.1, 1e-3 } });
            Check.Same(new double?[] { 0.1, 0.001, null }, all.Select(iteration => iteration.Milestone), "milestones");
            all = await ListAsync(curve, new WatchOptions { Digits = "auto" });
            Check.Equal(all.Count, (await ListAsync(curve, null)).Count, "iterations with rounded coordinates");
        }
    }

    public static async Task StreamsOfJobsWithDefaultsAreAsTheySay(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            var stream = new JObject { { "view", "samples" }, { "samples", 12 }, { "describe", "none" } };
            PiadJob job = await client.CreateAsync(new CurveRequest(Tests.Wave(20)) { Stream = stream });
            Check.Equal(12, (await ListAsync(job, null)).Last().Samples.Length, "samples by default");
            FitIteration last = (await ListAsync(job, new WatchOptions { View = "control_points" })).Last();
            Check.That(last.Curve.Knots != null, "knots are there although the job leaves them out");
        }
    }

    public static async Task ChangesMakeCompleteIterations(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            var method = new JObject { { "kind", "local" }, { "indices", new JArray(new JArray(2, 2), new JArray(2, 3)) } };
            double[][] weights = Enumerable.Range(0, 6).Select(i => Enumerable.Range(0, 5).Select(j => 1 + i * j / 20.0).ToArray()).ToArray();
            PiadJob surface = await client.CreateAsync(new SurfaceRequest(Tests.Hill(6, 5)) { Method = method, Weights = weights });
            List<FitIteration> changed = await ListAsync(surface, new WatchOptions { Changed = true });
            List<FitIteration> full = await ListAsync(surface, new WatchOptions { Encoding = "json" });
            Check.That(changed.Count > 3, "there are iterations");
            Check.Same(full.SelectMany(it => Tests.Flat(it.Surface.ControlPoints)), changed.SelectMany(it => Tests.Flat(it.Surface.ControlPoints)), "control points");
            Check.Same(full.SelectMany(it => Tests.Flat(it.Surface.Weights)), changed.SelectMany(it => Tests.Flat(it.Surface.Weights)), "weights");
            var local = new JObject { { "kind", "local" }, { "indices", new JArray(4, 5) } };
            PiadJob curve = await client.CreateAsync(new CurveRequest(Tests.Wave(12)) { Method = local });
            changed = await ListAsync(curve, new WatchOptions { Changed = true });
            full = await ListAsync(curve, null);
            Check.Same(full.SelectMany(it => Tests.Flat(it.Curve.ControlPoints)), changed.SelectMany(it => Tests.Flat(it.Curve.ControlPoints)), "control points of a curve");
        }
    }

    public static async Task DifferencesMakeIterations(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            double[][] weights = Enumerable.Range(0, 6).Select(i => Enumerable.Range(0, 5).Select(j => 1 + i * j / 20.0).ToArray()).ToArray();
            double[] line = Enumerable.Range(0, 300).Select(i => 1 + i % 3 / 2.0).ToArray();
            await CheckDifferencesAsync(await client.CreateAsync(new CurveRequest(Tests.Wave(300)) { Weights = line }));
            await CheckDifferencesAsync(await client.CreateAsync(new CurveRequest(Tests.Wave(300))));
            await CheckDifferencesAsync(await client.CreateAsync(new SurfaceRequest(Tests.Hill(6, 5)) { Weights = weights }));
        }
    }

    private static async Task CheckDifferencesAsync(PiadJob job)
    {
        foreach (string view in new[] { "control_points", "samples" })
        {
            List<FitIteration> full = await ListAsync(job, new WatchOptions { View = view, Encoding = "base64" });
            List<FitIteration> near = await ListAsync(job, new WatchOptions { View = view, Encoding = "delta" });
            Check.That(near.Count > 3, "there are iterations");
            Check.Same(full.Select(it => it.Number), near.Select(it => it.Number), "numbers of iterations");
            Check.Same(NumbersOf(full.Last()), NumbersOf(near.Last()), "the last iteration");
            for (int k = 0; k < near.Count; k++)
            {
                double[] expected = NumbersOf(full[k]), found = NumbersOf(near[k]);
                Check.Equal(expected.Length, found.Length, "count of numbers");
                double bound = full[k].Error.Max / 64 + 1e-13;
                Check.That(expected.Zip(found, (a, b) => Math.Abs(a - b)).All(distance => distance <= bound), "iteration " + k + " is near");
            }
        }
    }

    private static double[] NumbersOf(FitIteration it)
    {
        if (it.Samples != null) return Tests.Flat(it.Samples);
        if (it.SampleRows != null) return Tests.Flat(it.SampleRows);
        if (it.Curve != null) return Tests.Flat(it.Curve.ControlPoints).Concat(it.Curve.Weights ?? new double[0]).ToArray();
        return Tests.Flat(it.Surface.ControlPoints).Concat(Tests.Flat(it.Surface.Weights)).ToArray();
    }

    public static async Task KnotsMayChange(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            double[][] points = Enumerable.Range(0, 60).Select(i => new[] { i, Math.Pow(i % 20, 2) }).ToArray();
            var request = new CurveRequest(points) { Method = new JObject { { "kind", "least_squares" }, { "control_points", "auto" } }, Tolerance = 20 };
            var counts = new List<int>();
            FitStream stream = client.CreateStream(request);
            await stream.ForEachAsync(iteration =>
            {
                FittedCurve curve = iteration.Curve;
                counts.Add(curve.ControlPoints.Length);
                Check.Equal(curve.ControlPoints.Length + curve.Degree + 1, curve.Knots.Length, "knots of iteration " + iteration.Number);
            });
            Check.That(counts.Distinct().Count() > 1, "control points are inserted");
            FitIteration last = await (await client.JobAsync(stream.JobId)).IterationAsync();
            Check.Equal(counts.Last() + 4, last.Curve.Knots.Length, "knots of the last iteration alone");
        }
    }

    public static async Task DragsAreCompleteAndLeaveNothingBehind(Server server)
    {
        using (var own = new Server())
        using (var client = new PiadClient(own.Url))
        {
            PiadJob job = await client.CreateAsync(new CurveRequest(Tests.Wave(200)));
            await job.WaitAsync();
            FitIteration from = await job.IterationAsync();
            var local = new JObject { { "kind", "local" }, { "indices", new JArray(88, 89, 90, 91, 92) } };
            var options = new WatchOptions { Changed = true, Describe = "none", From = from };
            FitIteration dragged = null;
            foreach (double height in new[] { 1.1, 1.2, 1.3 })
            {
                var move = new EditRequest { Method = local, Ephemeral = true, Session = "drag" }.Move(90, new[] { 90, height, 0 });
                JobEnd end = await job.EditStream(move, options).ForEachAsync(iteration => dragged = iteration);
                Check.Equal("converged", end.State, "state of a drag");
            }
            Check.Equal(1, (await client.JobsAsync()).Count, "jobs after the drag");
            PiadJob edit = await job.EditAsync(new EditRequest { Method = local }.Move(90, new[] { 90, 1.3, 0 }));
            FittedCurve kept = (await edit.ResultAsync()).Curve;
            Check.Same(Tests.Flat(kept.ControlPoints), Tests.Flat(dragged.Curve.ControlPoints), "control points of the last frame");
            Check.Same(kept.Knots, dragged.Curve.Knots, "knots, which come from the parent");
        }
    }

    public static async Task ANewFrameEndsTheOneBefore(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            PiadJob job = await client.CreateAsync(new CurveRequest(Tests.Zigzag));
            await job.WaitAsync();
            EditRequest frame = new EditRequest { Ephemeral = true, Session = "s", Tolerance = 0, MaxIterations = 1000000000 }.Move(1, new[] { 1.0, 2.3 });
            using (FitStream before = job.EditStream(frame))
            {
                await before.NextAsync();
                EditRequest next = new EditRequest { Ephemeral = true, Session = "s" }.Move(1, new[] { 1.0, 2.6 });
                JobEnd end = await job.EditStream(next).ForEachAsync(iteration => { });
                Check.Equal("converged", end.State, "state of the new frame");
                while (await before.NextAsync() != null) { }
                Check.Equal("cancelled", before.End.State, "state of the frame before");
            }
        }
    }

    public static async Task ManyStreamsDoNotKeepOthersWaiting(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            FitStream[] streams = Enumerable.Range(0, 6).Select(_ => client.CreateStream(Tests.Endless(), new WatchOptions { Pace = "latest" })).ToArray();
            foreach (FitStream stream in streams) Check.That(await stream.NextAsync() != null, "a stream has begun");
            foreach (FitStream stream in streams)
            {
                PiadJob job = await client.JobAsync(stream.JobId);
                Check.Equal("cancelled", (await job.CancelAsync()).State, "state");
                while (await stream.NextAsync() != null) { }
                Check.Equal("cancelled", stream.End.State, "state at the end of the stream");
            }
        }
    }

    public static async Task AStreamThatIsLeftEndsItsJobIfAskedTo(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            FitStream stream = client.CreateStream(Tests.Endless(), new WatchOptions { CancelOnDisconnect = true });
            await stream.NextAsync();
            var time = Stopwatch.StartNew();
            stream.Dispose();
            Check.That(time.ElapsedMilliseconds < 1000, "leaving does not wait for the rest of the stream");
            PiadJob job = await client.JobAsync(stream.JobId);
            while (!job.Ended && time.Elapsed < TimeSpan.FromSeconds(20))
            {
                await Task.Delay(50);
                await job.RefreshAsync();
            }
            Check.Equal("cancelled", job.State, "state");
            await Check.ThrowsAsync<ObjectDisposedException>(stream.NextAsync());
        }
    }

    public static async Task SlowReadersMissNothing(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            var numbers = new List<long>();
            JobEnd end = await client.CreateStream(new CurveRequest(Tests.Wave(2000)) { Tolerance = 1e-9 }).ForEachAsync(async iteration =>
            {
                numbers.Add(iteration.Number);
                await Task.Delay(20);
            });
            Check.Same(Enumerable.Range(0, (int)end.Iterations + 1).Select(k => (long)k), numbers, "numbers");
        }
    }

    public static async Task IterationsDoNotStayInMemory(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            long before = GC.GetTotalMemory(true), most = 0, sent = 0;
            await client.CreateStream(new CurveRequest(Tests.Wave(10000)) { Tolerance = 0, MaxIterations = 100 }).ForEachAsync(iteration =>
            {
                most = Math.Max(most, GC.GetTotalMemory(true) - before);
                sent += iteration.Curve.ControlPoints.Length * 32;
            });
            // The garbage collector of Mono retains some unreachable objects.
            Check.That(sent > 30000000 && most < 16000000, most + " bytes are held of a stream of " + sent);
        }
    }

    public static async Task AStreamMayBeDisposedWhileItIsRead(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            PiadJob job = await client.CreateAsync(Tests.Endless());
            FitStream stream = job.Watch(new WatchOptions { View = "errors", Every = 1000000000 });
            await stream.NextAsync();
            Task<FitIteration> next = stream.NextAsync();
            await Task.Delay(100);
            stream.Dispose();
            var time = Stopwatch.StartNew();
            await Check.ThrowsAsync<ObjectDisposedException>(next);
            Check.That(time.ElapsedMilliseconds < 1000, "it ends at once");
            await job.CancelAsync();
        }
    }

#if NETCOREAPP3_0_OR_GREATER || PIAD_ASYNC_STREAMS
    public static async Task AwaitForeachGivesEachIteration(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            var numbers = new List<long>();
            FitStream stream = client.CreateStream(new CurveRequest(Tests.Wave(40)) { Tolerance = 1e-9 });
            await foreach (FitIteration iteration in stream) numbers.Add(iteration.Number);
            Check.Same(Enumerable.Range(0, (int)stream.End.Iterations + 1).Select(k => (long)k), numbers, "numbers");
            PiadJob job = await client.JobAsync(stream.JobId);
            using (var cancellation = new CancellationTokenSource())
            {
                numbers.Clear();
                Task loop = Task.Run(async () =>
                {
                    await foreach (FitIteration iteration in job.Watch().WithCancellation(cancellation.Token))
                    {
                        numbers.Add(iteration.Number);
                        if (iteration.Number == 3) cancellation.Cancel();
                    }
                });
                await Check.ThrowsAsync<OperationCanceledException>(loop);
                Check.Same(new long[] { 0, 1, 2, 3 }, numbers, "numbers until the loop is cancelled");
            }
            FitStream left = job.Watch();
            await foreach (FitIteration iteration in left) break;
            await Check.ThrowsAsync<ObjectDisposedException>(left.NextAsync());
        }
    }
#endif

    private static async Task<List<FitIteration>> ListAsync(PiadJob job, WatchOptions options)
    {
        var list = new List<FitIteration>();
        await job.WatchAsync(iteration => list.Add(iteration), options);
        return list;
    }
}

/// <summary>Broken connections and stopped servers.</summary>
public static class BreakTests
{
    public static async Task CutStreamsGoOn(Server server)
    {
        int cuts = 0;
        var relay = new Relay(after: (answer, number) =>
            answer.Content.Headers.ContentType.MediaType == "text/event-stream" && cuts++ < 3 ? CutStream.Cut(answer, 6000) : answer);
        using (var client = new PiadClient(server.Url, new PiadOptions { HttpMessageHandler = relay }))
        {
            await CheckCompleteAsync(client, new CurveRequest(Tests.Wave(20)) { Tolerance = 1e-9 });
            Check.Equal("POST /v1/jobs/stream", relay.Requests[0], "the first request");
            Check.Equal(4, relay.Requests.Count(request => request.Contains("stream") || request.Contains("events")), "connections");
            int[] after = relay.LastIds.Skip(1).Take(3).Select(int.Parse).ToArray();
            Check.That(after[0] > 0 && after[1] > after[0] && after[2] > after[1], "streams resume after an iteration: " + string.Join(", ", after));
        }
    }

    public static async Task SilentStreamsAreOpenedAgain(Server server)
    {
        int streams = 0;
        var relay = new Relay(after: (answer, number) =>
            answer.Content.Headers.ContentType.MediaType == "text/event-stream" && streams++ == 0 ? CutStream.Cut(answer, 5000, silent: true) : answer);
        var options = new PiadOptions { HttpMessageHandler = relay, StreamTimeout = TimeSpan.FromSeconds(0.5) };
        using (var client = new PiadClient(server.Url, options))
        {
            await CheckCompleteAsync(client, new CurveRequest(Tests.Wave(20)) { Tolerance = 1e-9 });
            Check.Equal(2, streams, "connections");
        }
    }

    public static async Task StreamsGiveUp(Server server)
    {
        var relay = new Relay(after: (answer, number) => CutStream.Cut(answer, 0));
        using (var client = new PiadClient(server.Url, new PiadOptions { HttpMessageHandler = relay, Attempts = 2 }))
        {
            await Check.ThrowsAsync<ConnectionLostException>(client.CreateStream(new CurveRequest(Tests.Zigzag)).NextAsync());
            Check.Equal(2, relay.Requests.Count, "attempts");
            Check.Equal(1, relay.Keys.Distinct().Count(), "keys of the requests for one job");
        }
    }

    public static async Task DragsDoNotGoOn(Server server)
    {
        var relay = new Relay(after: (answer, number) => number > 2 ? CutStream.Cut(answer, 3000) : answer);
        using (var client = new PiadClient(server.Url, new PiadOptions { HttpMessageHandler = relay }))
        {
            PiadJob job = await client.CreateAsync(new CurveRequest(Tests.Zigzag));
            await job.RefreshAsync();
            EditRequest frame = new EditRequest { Ephemeral = true, Tolerance = 0, MaxIterations = 1000000000 }.Move(1, new[] { 1.0, 2.5 });
            await Check.ThrowsAsync<ConnectionLostException>(job.EditStream(frame).ForEachAsync(iteration => { }));
            Check.Equal(3, relay.Requests.Count, "requests");
            Check.That(relay.Keys[2] == null, "an ephemeral edit has no key");
        }
    }

    public static async Task AKilledServerIsWaitedFor(Server server)
    {
        await SurviveAsync(own => own.Kill());
    }

    public static async Task AStoppedServerIsWaitedFor(Server server)
    {
        await SurviveAsync(own => own.Stop());
    }

    public static async Task RequestsWaitForAServerThatStartsAgain(Server server)
    {
        using (var own = new Server())
        using (var client = new PiadClient(own.Url))
        {
            await client.GetAsync("/v1/capabilities");
            own.Kill();
            Task<FitResult> fit = client.FitAsync(new CurveRequest(Tests.Zigzag));
            await Task.Delay(700);
            own.Start();
            Check.Equal("converged", (await fit).State, "state");
        }
    }

    public static async Task ALostAnswerMakesNoSecondJob(Server server)
    {
        using (var own = new Server())
        {
            var relay = new Relay(after: (answer, number) => { if (number == 1) throw new HttpRequestException("lost"); return answer; });
            using (var client = new PiadClient(own.Url, new PiadOptions { HttpMessageHandler = relay }))
            {
                PiadJob job = await client.CreateAsync(new CurveRequest(Tests.Zigzag));
                Check.Same(new[] { job.Id }, (await client.JobsAsync()).Select(other => other.Id), "jobs");
                Check.That(relay.Keys[0] != null && relay.Keys[0] == relay.Keys[1], "both requests have the same key");
                PiadJob second = await client.CreateAsync(new CurveRequest(Tests.Zigzag));
                Check.That(second.Id != job.Id, "another request is another job");
            }
        }
    }

    public static async Task ALostAnswerToADeletionIsNoError(Server server)
    {
        var relay = new Relay(after: (answer, number) => { if (number == 2) throw new HttpRequestException("lost"); return answer; });
        using (var client = new PiadClient(server.Url, new PiadOptions { HttpMessageHandler = relay }))
        {
            PiadJob job = await client.CreateAsync(new CurveRequest(Tests.Zigzag));
            await job.DeleteAsync();
            Check.Same(new[] { "POST", "DELETE", "DELETE" }, relay.Requests.Select(request => request.Split(' ')[0]), "requests");
            Check.Equal(404, (await Check.ThrowsAsync<ApiException>(job.DeleteAsync())).Status, "status of a second deletion");
        }
    }

    private static async Task SurviveAsync(Action<Server> end)
    {
        string folder = Path.Combine(Path.GetTempPath(), "piad-csharp-" + Guid.NewGuid());
        Directory.CreateDirectory(folder);
        try
        {
            var relay = new Relay();
            using (var own = new Server(Path.Combine(folder, "jobs")))
            using (var client = new PiadClient(own.Url, new PiadOptions { HttpMessageHandler = relay }))
            {
                bool ended = false;
                // More than is in transit when the server ends.
                await CheckCompleteAsync(client, new CurveRequest(Tests.Wave(10000)) { Tolerance = 1e-12 }, async iteration =>
                {
                    if (iteration.Number < 5 || ended) return;
                    ended = true;
                    await Task.Run(() => end(own));
                    own.Start();
                });
                Check.That(ended, "the server was ended");
                Check.That(relay.LastIds.Any(id => id != null && int.Parse(id) >= 5), "the stream was opened again: " + string.Join(", ", relay.LastIds));
            }
        }
        finally
        {
            Directory.Delete(folder, true);
        }
    }

    private static async Task CheckCompleteAsync(PiadClient client, CurveRequest request, Func<FitIteration, Task> after = null)
    {
        var numbers = new List<long>();
        FitIteration last = null;
        FitStream stream = client.CreateStream(request);
        JobEnd end = await stream.ForEachAsync(async iteration =>
        {
            numbers.Add(iteration.Number);
            last = iteration;
            if (after != null) await after(iteration);
        });
        Check.Same(Enumerable.Range(0, (int)end.Iterations + 1).Select(k => (long)k), numbers, "numbers");
        FitResult result = await (await client.JobAsync(stream.JobId)).ResultAsync();
        Check.Same(Tests.Flat(result.Curve.ControlPoints), Tests.Flat(last.Curve.ControlPoints), "control points of the last");
    }
}
