// Servers, handlers and checks for the tests.

using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.IO;
using System.Linq;
using System.Net;
using System.Net.Http;
using System.Net.Sockets;
using System.Text;
using System.Text.RegularExpressions;
using System.Threading;
using System.Threading.Tasks;

/// <summary>Assertions.</summary>
public static class Check
{
    public static void That(bool truth, string what)
    {
        if (!truth) throw new CheckFailed("not so: " + what);
    }

    public static void Equal<T>(T expected, T found, string what)
    {
        if (!EqualityComparer<T>.Default.Equals(expected, found)) throw new CheckFailed(what + ": expected " + expected + ", found " + found);
    }

    public static void Same<T>(IEnumerable<T> expected, IEnumerable<T> found, string what)
    {
        if (!expected.SequenceEqual(found)) throw new CheckFailed(what + ": expected " + string.Join(", ", expected) + "; found " + string.Join(", ", found));
    }

    public static void Near(double expected, double found, double distance, string what)
    {
        if (!(Math.Abs(expected - found) <= distance)) throw new CheckFailed(what + ": expected " + expected + " ± " + distance + ", found " + found);
    }

    public static T Throws<T>(Action action) where T : Exception
    {
        try { action(); }
        catch (T error) { return error; }
        throw new CheckFailed("no " + typeof(T).Name + " was thrown");
    }

    public static async Task<T> ThrowsAsync<T>(Task task) where T : Exception
    {
        try { await task; }
        catch (T error) { return error; }
        throw new CheckFailed("no " + typeof(T).Name + " was thrown");
    }
}

public sealed class CheckFailed : Exception
{
    public CheckFailed(string message) : base(message) { }
}

/// <summary>A server that can be killed and restarted at the same address.</summary>
public sealed class Server : IDisposable
{
    public static string Program;

    private readonly string store;
    private readonly string token;
    private readonly string more;
    private int port;
    private Process process;

    /// <summary>With a `store`, a file, its jobs are persistent.</summary>
    public Server(string store = ":memory:", string token = null, string more = "")
    {
        this.store = store;
        this.token = token;
        this.more = more;
        Start();
    }

    public string Url { get { return "http://127.0.0.1:" + port; } }

    public void Start()
    {
        string arguments = "--listen 127.0.0.1:" + port + " --store " + store + " --log-format json --max-iterations 1000000000 " + more;
        var information = new ProcessStartInfo(Program, arguments) { UseShellExecute = false, RedirectStandardError = true };
        if (token != null) information.EnvironmentVariables["PIAD_TOKEN"] = token;
        process = Process.Start(information);
        var listening = new TaskCompletionSource<int>();
        process.ErrorDataReceived += (sender, line) =>
        {
            Match match = Regex.Match(line.Data ?? "", @"listening on http://127\.0\.0\.1:(\d+)");
            if (match.Success) listening.TrySetResult(int.Parse(match.Groups[1].Value));
            if (line.Data == null) listening.TrySetException(new InvalidOperationException("the server did not start"));
        };
        process.BeginErrorReadLine();
        if (!listening.Task.Wait(TimeSpan.FromSeconds(30))) throw new InvalidOperationException("the server did not start within 30 s");
        port = listening.Task.Result;
    }

    public void Kill()
    {
        process.Kill();
        process.WaitForExit();
    }

    /// <summary>Shuts it down like an operator.</summary>
    public void Stop()
    {
        using (Process kill = Process.Start(new ProcessStartInfo("kill", "-TERM " + process.Id) { UseShellExecute = false })) kill.WaitForExit();
        process.WaitForExit();
    }

    public void Dispose()
    {
        if (!process.HasExited) Kill();
        process.Dispose();
    }
}

/// <summary>Forwards requests: `before` may respond itself, `after` may change or lose a response.
/// Both get the number of requests so far, including this one.</summary>
public sealed class Relay : DelegatingHandler
{
    public readonly List<string> Requests = new List<string>();
    public readonly List<string> Keys = new List<string>();
    public readonly List<string> LastIds = new List<string>();

    private readonly Func<HttpRequestMessage, int, HttpResponseMessage> before;
    private readonly Func<HttpResponseMessage, int, HttpResponseMessage> after;

    public Relay(Func<HttpRequestMessage, int, HttpResponseMessage> before = null, Func<HttpResponseMessage, int, HttpResponseMessage> after = null)
        : base(new HttpClientHandler { MaxConnectionsPerServer = 64 })
    {
        this.before = before;
        this.after = after;
    }

    public static HttpResponseMessage Answer(int status, string body = "", string type = "text/plain", string retryAfter = null)
    {
        var response = new HttpResponseMessage((HttpStatusCode)status) { Content = new StringContent(body, Encoding.UTF8, type) };
        if (retryAfter != null) response.Headers.TryAddWithoutValidation("Retry-After", retryAfter);
        return response;
    }

    protected override async Task<HttpResponseMessage> SendAsync(HttpRequestMessage request, CancellationToken cancellation)
    {
        int number;
        lock (Requests)
        {
            Requests.Add(request.Method + " " + request.RequestUri.AbsolutePath);
            Keys.Add(Header(request, "Idempotency-Key"));
            LastIds.Add(Header(request, "Last-Event-ID"));
            number = Requests.Count;
        }
        HttpResponseMessage answer = before == null ? null : before(request, number);
        if (answer != null) return answer;
        answer = await base.SendAsync(request, cancellation);
        return after == null ? answer : after(answer, number);
    }

    private static string Header(HttpRequestMessage request, string name)
    {
        IEnumerable<string> values;
        return request.Headers.TryGetValues(name, out values) ? values.First() : null;
    }
}

/// <summary>Forwards a stream up to some byte, after which it disconnects or stays
/// silent.</summary>
public sealed class CutStream : Stream
{
    private readonly Stream inner;
    private readonly bool silent;
    private int left;

    public CutStream(Stream inner, int bytes, bool silent)
    {
        this.inner = inner;
        this.silent = silent;
        left = bytes;
    }

    /// <summary>A response with a truncated body.</summary>
    public static HttpResponseMessage Cut(HttpResponseMessage response, int bytes, bool silent = false)
    {
        var content = new StreamContent(new CutStream(response.Content.ReadAsStreamAsync().Result, bytes, silent));
        content.Headers.TryAddWithoutValidation("Content-Type", response.Content.Headers.ContentType.ToString());
        response.Content = content;
        return response;
    }

    public override bool CanRead { get { return true; } }
    public override bool CanSeek { get { return false; } }
    public override bool CanWrite { get { return false; } }
    public override long Length { get { throw new NotSupportedException(); } }
    public override long Position { get { throw new NotSupportedException(); } set { throw new NotSupportedException(); } }

    public override async Task<int> ReadAsync(byte[] buffer, int offset, int count, CancellationToken cancellation)
    {
        if (left == 0 && silent) await Task.Delay(Timeout.Infinite, cancellation);
        if (left == 0) throw new IOException("the connection was cut");
        int read = await inner.ReadAsync(buffer, offset, Math.Min(count, left), cancellation);
        left -= read;
        return read;
    }

    public override int Read(byte[] buffer, int offset, int count) { return ReadAsync(buffer, offset, count, CancellationToken.None).Result; }
    public override void Flush() { }
    public override long Seek(long offset, SeekOrigin origin) { throw new NotSupportedException(); }
    public override void SetLength(long value) { throw new NotSupportedException(); }
    public override void Write(byte[] buffer, int offset, int count) { throw new NotSupportedException(); }

    protected override void Dispose(bool disposing)
    {
        inner.Dispose();
        base.Dispose(disposing);
    }
}

/// <summary>A port without a server.</summary>
public static class Port
{
    public static int Unused()
    {
        var listener = new TcpListener(IPAddress.Loopback, 0);
        listener.Start();
        int port = ((IPEndPoint)listener.LocalEndpoint).Port;
        listener.Stop();
        return port;
    }
}
