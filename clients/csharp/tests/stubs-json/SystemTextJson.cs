// Stubs: signatures of System.Text.Json 8 as far as Piad.cs calls them with PIAD_SYSTEM_TEXT_JSON,
// to compile it without the library. They are not run.

using System;
using System.Collections;
using System.Collections.Generic;

namespace System.Text.Json
{
    public class JsonException : Exception { }

    public enum JsonValueKind : byte { Undefined, Object, Array, String, Number, True, False, Null }

    public struct JsonDocumentOptions { }

    public sealed class JsonSerializerOptions { }
}

namespace System.Text.Json.Nodes
{
    public struct JsonNodeOptions { }

    public abstract class JsonNode
    {
        public JsonNode this[int index] { get { throw Stub.Called(); } set { throw Stub.Called(); } }
        public JsonNode this[string propertyName] { get { throw Stub.Called(); } set { throw Stub.Called(); } }

        public static JsonNode Parse(string json, JsonNodeOptions? nodeOptions = null, JsonDocumentOptions documentOptions = default(JsonDocumentOptions)) { throw Stub.Called(); }
        public static implicit operator JsonNode(string value) { throw Stub.Called(); }
        public static implicit operator JsonNode(double value) { throw Stub.Called(); }
        public string ToJsonString(JsonSerializerOptions options = null) { throw Stub.Called(); }
        public JsonNode DeepClone() { throw Stub.Called(); }
        public JsonValueKind GetValueKind() { throw Stub.Called(); }
        public T GetValue<T>() { throw Stub.Called(); }
    }

    public sealed class JsonObject : JsonNode, IEnumerable<KeyValuePair<string, JsonNode>>
    {
        public JsonObject(JsonNodeOptions? options = null) { }
        public bool ContainsKey(string propertyName) { throw Stub.Called(); }
        public IEnumerator<KeyValuePair<string, JsonNode>> GetEnumerator() { throw Stub.Called(); }
        IEnumerator IEnumerable.GetEnumerator() { throw Stub.Called(); }
    }

    public sealed class JsonArray : JsonNode, IEnumerable<JsonNode>
    {
        public JsonArray(JsonNodeOptions? options = null) { }
        public int Count { get { throw Stub.Called(); } }
        public void Add(JsonNode item) { throw Stub.Called(); }
        public void Add<T>(T value) { throw Stub.Called(); }
        public IEnumerator<JsonNode> GetEnumerator() { throw Stub.Called(); }
        IEnumerator IEnumerable.GetEnumerator() { throw Stub.Called(); }
    }

    public abstract class JsonValue : JsonNode
    {
        public static JsonValue Create(bool value, JsonNodeOptions? options = null) { throw Stub.Called(); }
        public static JsonValue Create(double value, JsonNodeOptions? options = null) { throw Stub.Called(); }
        public static JsonValue Create(long value, JsonNodeOptions? options = null) { throw Stub.Called(); }
        public static JsonValue Create(string value, JsonNodeOptions? options = null) { throw Stub.Called(); }
    }

    internal static class Stub
    {
        internal static Exception Called() { return new NotSupportedException("a stub was called"); }
    }
}
