// Errors, cancellation and rejected requests.

using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Linq;
using System.Net.Http;
using System.Threading;
using System.Threading.Tasks;
using Newtonsoft.Json.Linq;
using Piad;

/// <summary>Errors of client and server, and cancellation.</summary>
public static class MistakeTests
{
    private const string Token = "0123456789abcdef0123456789abcdef";

    public static async Task NobodyIsThere(Server server)
    {
        var time = Stopwatch.StartNew();
        string url = "http://127.0.0.1:" + Port.Unused();
        var relay = new Relay();
        using (var client = new PiadClient(url, new PiadOptions { HttpMessageHandler = relay }))
        {
            ConnectionLostException error = await Check.ThrowsAsync<ConnectionLostException>(client.FitAsync(new CurveRequest(Tests.Zigzag)));
            Check.That(error.Message.StartsWith("cannot reach " + url), error.Message);
            Check.Equal(3, relay.Requests.Count, "attempts");
            Check.That(time.Elapsed < TimeSpan.FromSeconds(10), "it is known soon");
        }
    }

    public static Task AddressesAreChecked(Server server)
    {
        foreach (string url in new[] { "127.0.0.1:8080", "ftp://host", "", null })
        {
            ArgumentException error = Check.Throws<ArgumentException>(() => new PiadClient(url));
            Check.That(error.Message.Contains("begins with http:// or https://"), error.Message);
        }
        Check.Throws<ArgumentException>(() => new PiadClient(server.Url, new PiadOptions { Attempts = 0 }));
        return Task.FromResult(true);
    }

    public static async Task TheAddressMayHaveASlash(Server server)
    {
        using (var client = new PiadClient(server.Url + "/"))
        {
            Check.Equal("converged", (await client.FitAsync(new CurveRequest(Tests.Zigzag))).State, "state");
        }
    }

    public static async Task WrongRequestsHavePointers(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            var points = new[] { new[] { 0.0, 0 }, new[] { 1.0, 1 }, new[] { 1.0, 1 } };
            ApiException error = await Check.ThrowsAsync<ApiException>(client.CreateAsync(new CurveRequest(points)));
            Check.Equal(422, error.Status, "status");
            Check.Equal("/problems/invalid-fit", error.Type, "type");
            Check.Same(new[] { "/curve/points/2" }, error.Pointers, "pointers");
            Check.That(error.Detail.Contains("point 2 equals point 1") && error.Message.Contains(error.Detail), error.Message);
            Check.That(error.Title.Length > 0 && error.RequestId.Length > 0, "the problem has a title and an id");
            var both = new JObject { { "curve", new JObject { { "points", new JArray(new JArray(0, 0), new JArray(1, 1), new JArray(2, 0)) } } }, { "stop", new JObject { { "tolerance", -1 } } }, { "name", new string('x', 300) } };
            error = await Check.ThrowsAsync<ApiException>(client.CreateAsync(both));
            Check.That(error.Pointers.Length >= 1 && error.Status == 422, "pointers: " + string.Join(", ", error.Pointers));
            error = await Check.ThrowsAsync<ApiException>(client.CreateAsync(new JObject { { "curv", 1 } }));
            Check.That(error.Status == 422 && error.Detail.Contains("curv"), error.Message);
            error = await Check.ThrowsAsync<ApiException>(client.CreateStream(new CurveRequest(points)).NextAsync());
            Check.Same(new[] { "/curve/points/2" }, error.Pointers, "pointers of a stream");
        }
    }

    public static async Task NumbersMustBeFinite(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            var points = new[] { new[] { 0.0, 0 }, new[] { 1.0, double.NaN }, new[] { 2.0, 1 } };
            ArgumentException error = await Check.ThrowsAsync<ArgumentException>(CreateAsync(client, points));
            Check.Equal("curve.points[1][1] is NaN: numbers must be finite", error.Message, "message");
        }
    }

    public static async Task FitsOfOneRequestMustConverge(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            var request = new CurveRequest(Tests.Wave(30)) { Tolerance = 1e-9, MaxIterations = 2 };
            Check.Equal("/problems/not-converged", (await Check.ThrowsAsync<ApiException>(client.FitOnceAsync(request))).Type, "type");
            Check.Equal("exhausted", (await client.FitAsync(request)).State, "state of a job");
        }
    }

    public static async Task CancellingEndsWaitingAndStreams(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            PiadJob job = await client.CreateAsync(Tests.Endless());
            using (var soon = new CancellationTokenSource(300)) await CancelledAsync(job.WaitAsync(soon.Token));
            using (var soon = new CancellationTokenSource(300)) await CancelledAsync(client.FitAsync(Tests.Endless(), soon.Token));
            using (var soon = new CancellationTokenSource(300)) await CancelledAsync(client.FitOnceAsync(Tests.Endless(), soon.Token));
            using (var soon = new CancellationTokenSource(300)) await CancelledAsync(job.WatchAsync(iteration => { }, null, soon.Token));
            using (var now = new CancellationTokenSource())
            {
                long last = -1;
                await CancelledAsync(job.WatchAsync(iteration =>
                {
                    last = iteration.Number;
                    if (last == 3) now.Cancel();
                }, null, now.Token));
                Check.Equal(3L, last, "last iteration");
            }
            await job.CancelAsync();
            Check.Equal("cancelled", (await job.ResultAsync()).State, "state of what there is");
            foreach (PiadJob other in await client.JobsAsync("running")) await other.CancelAsync();
        }
    }

    public static async Task CancellingEndsPauses(Server server)
    {
        var relay = new Relay((request, number) => Relay.Answer(503, retryAfter: "30"));
        using (var client = new PiadClient(server.Url, new PiadOptions { HttpMessageHandler = relay }))
        using (var soon = new CancellationTokenSource(300))
        {
            await CancelledAsync(client.GetAsync("/v1/jobs", soon.Token));
        }
    }

    public static async Task ASilentStreamCanBeCancelled(Server server)
    {
        var relay = new Relay(after: (answer, number) => CutStream.Cut(answer, 3000, silent: true));
        using (var client = new PiadClient(server.Url, new PiadOptions { HttpMessageHandler = relay }))
        using (var soon = new CancellationTokenSource(500))
        {
            await CancelledAsync(client.CreateStream(Tests.Endless(), new WatchOptions { CancelOnDisconnect = true }).ForEachAsync(iteration => { }, soon.Token));
        }
    }

    public static async Task AnExceptionOfACallbackIsThrown(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            PiadJob job = await client.CreateAsync(new CurveRequest(Tests.Zigzag));
            await Check.ThrowsAsync<DivideByZeroException>(job.WatchAsync(iteration => { throw new DivideByZeroException(); }));
        }
    }

    public static async Task EndedJobsCannotBeCancelled(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            PiadJob job = await client.CreateAsync(new CurveRequest(Tests.Zigzag));
            await job.WaitAsync();
            ApiException error = await Check.ThrowsAsync<ApiException>(job.CancelAsync());
            Check.Equal("409 /problems/already-ended", error.Status + " " + error.Type, "problem");
            Check.Throws<ArgumentException>(() => job.Watch(new WatchOptions { CancelOnDisconnect = true }));
        }
    }

    public static async Task AFailedJobHasNoResult(Server server)
    {
        const string Failed = "{\"id\":\"1\",\"state\":\"failed\",\"iteration\":4,\"problem\":{\"type\":\"/problems/overflow\",\"detail\":\"numbers became infinite\"}}";
        var relay = new Relay((request, number) => Relay.Answer(201, Failed, "application/json"));
        using (var client = new PiadClient(server.Url, new PiadOptions { HttpMessageHandler = relay }))
        {
            JobFailedException error = await Check.ThrowsAsync<JobFailedException>(client.FitAsync(new CurveRequest(Tests.Zigzag)));
            Check.Equal("1 failed /problems/overflow", error.JobId + " " + error.State + " " + error.Type, "what failed");
            Check.Equal("the job 1 is failed: numbers became infinite", error.Message, "message");
        }
    }

    public static async Task AServerWithoutRoomIsAskedAgainAfterItsTime(Server server)
    {
        foreach (int status in new[] { 429, 503 })
        {
            var relay = new Relay((request, number) => number == 1 ? Relay.Answer(status, "busy", retryAfter: "1") : null);
            using (var client = new PiadClient(server.Url, new PiadOptions { HttpMessageHandler = relay }))
            {
                var time = Stopwatch.StartNew();
                PiadJob job = await client.CreateAsync(new CurveRequest(Tests.Zigzag));
                Check.That(job.Id.Length > 0 && time.ElapsedMilliseconds >= 1000 && time.ElapsedMilliseconds < 5000, "it took " + time.ElapsedMilliseconds + " ms");
                Check.Equal(relay.Keys[0], relay.Keys[1], "key of the second request");
            }
        }
    }

    public static async Task StreamsWaitForRoomToo(Server server)
    {
        var relay = new Relay((request, number) => number <= 2 ? Relay.Answer(503, "busy", retryAfter: "0") : null);
        using (var client = new PiadClient(server.Url, new PiadOptions { HttpMessageHandler = relay }))
        {
            JobEnd end = await client.CreateStream(new CurveRequest(Tests.Zigzag)).ForEachAsync(iteration => { });
            Check.Equal("converged", end.State, "state");
            Check.Equal(3, relay.Requests.Count, "requests");
        }
    }

    public static async Task WaitingHasAnEnd(Server server)
    {
        var relay = new Relay((request, number) => Relay.Answer(502, "<html>no gateway</html>", "text/html"));
        using (var client = new PiadClient(server.Url, new PiadOptions { HttpMessageHandler = relay, Attempts = 3 }))
        {
            ApiException error = await Check.ThrowsAsync<ApiException>(client.GetAsync("/v1/jobs"));
            Check.Equal("502 about:blank <html>no gateway</html>", error.Status + " " + error.Type + " " + error.Detail, "what a proxy says");
            Check.Equal(3, relay.Requests.Count, "attempts");
        }
        relay = new Relay((request, number) => Relay.Answer(503, "later", retryAfter: "3600"));
        using (var client = new PiadClient(server.Url, new PiadOptions { HttpMessageHandler = relay }))
        {
            ApiException error = await Check.ThrowsAsync<ApiException>(client.GetAsync("/v1/jobs"));
            Check.Equal(TimeSpan.FromHours(1), error.RetryAfter.Value, "Retry-After");
            Check.Equal(1, relay.Requests.Count, "attempts at a server that is away for an hour");
        }
    }

    public static async Task OtherServersAreRecognised(Server server)
    {
        var relay = new Relay((request, number) => Relay.Answer(200, "<html>", "text/html"));
        using (var client = new PiadClient(server.Url, new PiadOptions { HttpMessageHandler = relay }))
        {
            await Check.ThrowsAsync<ProtocolException>(client.GetAsync("/v1/jobs"));
            Check.Equal(1, relay.Requests.Count, "attempts");
        }
        relay = new Relay((request, number) => Relay.Answer(200, "event: iteration\ndata: {\"iteration\":1}\n\n", "text/event-stream"));
        using (var client = new PiadClient(server.Url, new PiadOptions { HttpMessageHandler = relay }))
        {
            await Check.ThrowsAsync<ProtocolException>(client.CreateStream(new CurveRequest(Tests.Zigzag)).NextAsync());
        }
    }

    public static async Task ASilentServerIsGivenUp(Server server)
    {
        var relay = new Relay(after: (answer, number) => CutStream.Cut(answer, 10, silent: true));
        using (var client = new PiadClient(server.Url, new PiadOptions { HttpMessageHandler = relay, Attempts = 2, Timeout = TimeSpan.FromSeconds(0.3) }))
        {
            ConnectionLostException error = await Check.ThrowsAsync<ConnectionLostException>(client.GetAsync("/v1/capabilities"));
            Check.That(error.Message.Contains("0.3 s of silence"), error.Message);
        }
    }

    public static async Task TokensAreSent(Server server)
    {
        using (var guarded = new Server(token: Token))
        using (var without = new PiadClient(guarded.Url))
        using (var with = new PiadClient(guarded.Url, new PiadOptions { Token = Token }))
        {
            ApiException error = await Check.ThrowsAsync<ApiException>(without.CreateAsync(new CurveRequest(Tests.Zigzag)));
            Check.Equal("401 /problems/unauthenticated", error.Status + " " + error.Type, "problem");
            PiadJob job = await with.CreateAsync(new CurveRequest(Tests.Zigzag));
            Check.Equal("converged", (await job.WaitAsync()).State, "state");
            string ticket = await job.TicketAsync();
            using (var browser = new HttpClient())
            {
                string events = await browser.GetStringAsync(guarded.Url + "/v1/jobs/" + job.Id + "/events?ticket=" + Uri.EscapeDataString(ticket));
                Check.That(events.Contains("event: end"), "the ticket opens the stream");
            }
        }
    }

    public static async Task AServerWithoutTokensHasNoTickets(Server server)
    {
        using (var client = new PiadClient(server.Url))
        {
            PiadJob job = await client.CreateAsync(new CurveRequest(Tests.Zigzag));
            ApiException error = await Check.ThrowsAsync<ApiException>(job.TicketAsync());
            Check.Equal("409 /problems/no-tickets", error.Status + " " + error.Type, "problem");
        }
    }

    private static async Task<PiadJob> CreateAsync(PiadClient client, double[][] points)
    {
        return await client.CreateAsync(new CurveRequest(points));
    }

    private static async Task CancelledAsync(Task task)
    {
        var time = Stopwatch.StartNew();
        await Check.ThrowsAsync<OperationCanceledException>(task);
        Check.That(time.ElapsedMilliseconds < 3000, "cancelling took " + time.ElapsedMilliseconds + " ms");
    }
}
