// The conformance program of this client: `conformance SCENARIO URL TOKEN` reads a JSON document
// from standard input, talks to the server through Piad.cs, and prints one JSON object.

using System;
using System.Collections.Generic;
using System.Globalization;
using System.IO;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;
using Newtonsoft.Json;
using Newtonsoft.Json.Linq;
using Piad;

public static class Conformance
{
    public static int Main(string[] arguments)
    {
        try
        {
            if (arguments.Length != 3) throw new ArgumentException("usage: conformance SCENARIO URL TOKEN < document");
            JObject document = Parse(new StreamReader(Console.OpenStandardInput()).ReadToEnd());
            JObject answer = RunAsync(arguments[0], arguments[1], arguments[2], document).GetAwaiter().GetResult();
            Console.WriteLine(Write(answer));
            return 0;
        }
        catch (Exception error)
        {
            Console.Error.WriteLine(error);
            return 1;
        }
        finally
        {
            // Mono aborts its timer thread at exit, and crashes if that is sorting its timers.
            Thread.Sleep(100);
        }
    }

    private static async Task<JObject> RunAsync(string scenario, string url, string token, JObject document)
    {
        using (var client = new PiadClient(url, new PiadOptions { Token = token }))
        {
            switch (scenario)
            {
                case "fit": return Answer(await client.FitAsync(document));
                case "watch": return await WatchAsync(client, document, iteration => Task.FromResult(true));
                case "resume": return await WatchAsync(client, document, ReadyAsync);
                case "cancel": return await CancelAsync(client, document);
                case "edit": return await EditAsync(client, document);
                case "errors": return await ErrorsAsync(client, document);
                case "tokens": return await TokensAsync(client, url, document);
                case "large": return await LargeAsync(client, document);
                case "differences": return await DifferencesAsync(client, document);
                case "slow": return await SlowAsync(client, document);
                default: throw new ArgumentException("there is no scenario " + scenario);
            }
        }
    }

    private static async Task<JObject> WatchAsync(PiadClient client, JObject request, Func<FitIteration, Task> after)
    {
        var numbers = new JArray();
        double[] first = null, last = null;
        JobEnd end = await client.CreateStream(request).ForEachAsync(async iteration =>
        {
            numbers.Add(iteration.Number);
            last = Flat(iteration.Curve, iteration.Surface);
            first = first ?? last;
            await after(iteration);
        });
        return new JObject { { "numbers", numbers }, { "first", List(first) }, { "last", List(last) }, { "state", end.State } };
    }

    private static Task ReadyAsync(FitIteration iteration)
    {
        if (iteration.Number == 5)
        {
            Console.WriteLine("ready");
            Console.Out.Flush();
        }
        return Task.FromResult(true);
    }

    private static async Task<JObject> CancelAsync(PiadClient client, JObject request)
    {
        using (FitStream stream = client.CreateStream(request))
        {
            await stream.NextAsync();
            PiadJob job = await client.JobAsync(stream.JobId);
            await job.CancelAsync();
            string state = job.State;
            // Repeated, without effect.
            await job.CancelAsync();
            return new JObject { { "state", state }, { "again", job.State } };
        }
    }

    private static async Task<JObject> EditAsync(PiadClient client, JObject document)
    {
        PiadJob job = await client.CreateAsync((JObject)document["job"]);
        await job.WaitAsync();
        PiadJob edit = await job.EditAsync((JObject)document["edit"]);
        JObject answer = Answer(await edit.ResultAsync());
        answer["parent"] = job.Id;
        answer["is_parent"] = edit.Parent == job.Id;
        return answer;
    }

    private static async Task<JObject> ErrorsAsync(PiadClient client, JObject request)
    {
        ApiException error = await RefusalAsync(client.CreateAsync(request));
        return new JObject
        {
            { "status", error.Status }, { "type", error.Type }, { "pointers", new JArray(error.Pointers) }, { "detail", error.Detail },
        };
    }

    private static async Task<JObject> TokensAsync(PiadClient client, string url, JObject request)
    {
        using (var without = new PiadClient(url))
        {
            ApiException refusal = await RefusalAsync(without.CreateAsync(request));
            PiadJob job = await client.CreateAsync(request);
            return new JObject { { "without", refusal.Type }, { "with", (await job.WaitAsync()).State } };
        }
    }

    private static async Task<JObject> LargeAsync(PiadClient client, JObject request)
    {
        var numbers = new JArray();
        FitIteration last = null;
        await client.CreateStream(request, new WatchOptions { Encoding = "base64" }).ForEachAsync(iteration =>
        {
            numbers.Add(iteration.Number);
            last = iteration;
        });
        double[] coordinates = Flat(last.Curve, last.Surface);
        return new JObject { { "numbers", numbers }, { "count", coordinates.Length }, { "sum", coordinates.Sum() } };
    }

    private static async Task<JObject> DifferencesAsync(PiadClient client, JObject request)
    {
        var numbers = new JArray();
        var points = new JArray();
        JobEnd end = await client.CreateStream(request, new WatchOptions { Encoding = "delta" }).ForEachAsync(iteration =>
        {
            numbers.Add(iteration.Number);
            points.Add(List(Flat(iteration.Curve, iteration.Surface)));
        });
        return new JObject { { "numbers", numbers }, { "points", points }, { "state", end.State } };
    }

    private static async Task<JObject> SlowAsync(PiadClient client, JObject request)
    {
        var numbers = new JArray();
        JobEnd end = await client.CreateStream(request).ForEachAsync(async iteration =>
        {
            numbers.Add(iteration.Number);
            await Task.Delay(20);
        });
        return new JObject { { "numbers", numbers }, { "state", end.State } };
    }

    private static async Task<ApiException> RefusalAsync(Task<PiadJob> request)
    {
        try
        {
            await request;
        }
        catch (ApiException error)
        {
            return error;
        }
        throw new InvalidOperationException("the server did not refuse the request");
    }

    private static JObject Answer(FitResult result)
    {
        double[] knots = result.Curve == null ? result.Surface.KnotsU : result.Curve.Knots;
        return new JObject
        {
            { "state", result.State },
            { "iteration", result.Iteration },
            { "error", result.Error.Max },
            { "control_points", List(Flat(result.Curve, result.Surface)) },
            { "knots", knots == null ? JValue.CreateNull() : (JToken)List(knots) },
        };
    }

    private static double[] Flat(FittedCurve curve, FittedSurface surface)
    {
        IEnumerable<double[]> points = curve == null ? surface.ControlPoints.SelectMany(row => row) : curve.ControlPoints;
        return points.SelectMany(point => point).ToArray();
    }

    private static JArray List(double[] numbers)
    {
        return new JArray(numbers.Cast<object>().ToArray());
    }

    private static JObject Parse(string text)
    {
        return JObject.Load(new JsonTextReader(new StringReader(text)) { DateParseHandling = DateParseHandling.None });
    }

    private static string Write(JObject value)
    {
        var text = new StringWriter(CultureInfo.InvariantCulture);
        using (var writer = new Exact(text)) value.WriteTo(writer);
        return text.ToString();
    }

    // Doubles with 17 significant digits.
    private sealed class Exact : JsonTextWriter
    {
        public Exact(TextWriter writer) : base(writer) { }

        public override void WriteValue(double value)
        {
            if (double.IsNaN(value) || double.IsInfinity(value)) WriteNull();
            else WriteRawValue(value.ToString("G17", CultureInfo.InvariantCulture));
        }
    }
}
