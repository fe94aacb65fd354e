// A client of piad, the service that fits curves and surfaces to data points and streams every iteration.
//
// One header for C++17 on libcurl (7.66 or later) and nlohmann-json (3.9 or later). README.md describes its use,
// docs/reference/job.md and docs/reference/events.md of the project describe requests and streams.
//
//     piad::Client client("http://127.0.0.1:8080");
//     piad::Result result = client.fit({{"curve", {{"points", {{0, 0}, {1, 2}, {3, 1}, {4, 3}}}}}});
//
// A Client may be used by several threads at once. A Job belongs to one thread at a time; copies are independent.

#ifndef PIAD_PIAD_HPP
#define PIAD_PIAD_HPP

#include <curl/curl.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

static_assert(LIBCURL_VERSION_NUM >= 0x074200, "piad needs libcurl 7.66 or later");

namespace piad {

using Json = nlohmann::json;

// ---------------------------------------------------------------------------------------------- Errors
//
// Errors that are found before anything is sent, such as an invalid URL or a coordinate that is not finite, throw
// std::invalid_argument. All later errors are derived from piad::Error.

// The base of all exceptions of valid calls.
struct Error : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// The server was unreachable or the connection broke on each attempt.
struct ConnectionLost : Error {
    explicit ConnectionLost(const std::string& what, bool is_permanent = false) : Error(what), permanent(is_permanent) {}

    bool permanent;  // A retry cannot help: for example, the certificate is invalid.
};

// The response does not conform to this API.
struct ProtocolError : Error {
    using Error::Error;
};

// A stop token cancelled the call.
struct Stopped : Error {
    Stopped() : Error("stopped by its stop token") {}
};

// One error of a request. Only the location that applies is set.
struct FieldError {
    std::string detail;
    std::string pointer;    // JSON pointer into the body (RFC 6901)
    std::string parameter;  // query parameter
    std::string header;
    std::uint64_t line = 0;  // line of a file of points, counted from 1
};

// A problem object (RFC 9457), in error responses and failed jobs.
struct Problem {
    std::string type = "about:blank";  // such as "/problems/invalid-fit"; "about:blank" for other servers
    std::string title;
    int status = 0;  // HTTP status
    std::string detail;
    std::vector<FieldError> errors;
    std::vector<std::string> pointers;  // those of `errors`
    std::string request_id;             // the id of the request in the log of the server
};

// The server rejected a request.
struct ApiError : Error, Problem {
    explicit ApiError(const Problem& problem, std::optional<double> seconds = {})
        : Error(std::to_string(problem.status) + " " + problem.title + ": " + problem.detail),
          Problem(problem),
          retry_after(seconds) {}

    std::optional<double> retry_after;  // delay in seconds requested by the server
};

// A job ended without a result.
struct JobFailed : Error {
    JobFailed(std::string job, std::string job_state, std::optional<Problem> why)
        : Error("the job " + job + " is " + job_state + (why ? ": " + why->detail : "")),
          id(std::move(job)),
          state(std::move(job_state)),
          problem(std::move(why)) {}

    std::string id;
    std::string state;  // "failed" or "cancelled"
    std::optional<Problem> problem;
};

// --------------------------------------------------------------------------------------- Cancellation

namespace detail {

struct StopState {
    std::mutex mutex;
    std::condition_variable changed;
    std::atomic<bool> stopped{false};
};

}  // namespace detail

// Cancels calls: they throw `Stopped` within about 50 ms, also during a transfer or while waiting for a retry. A
// default-constructed token never cancels.
class StopToken {
public:
    using Clock = std::chrono::steady_clock;

    StopToken() = default;

    // A token that also cancels after this time.
    StopToken after(std::chrono::milliseconds time) const {
        StopToken token(*this);
        token.deadline_ = (std::min)(deadline_, Clock::now() + time);
        return token;
    }

    bool stopped() const { return (state_ && state_->stopped) || (has_deadline() && Clock::now() >= deadline_); }

    // True if it can cancel.
    bool possible() const { return state_ || has_deadline(); }

    // Throws `Stopped` if it is cancelled.
    void throw_if_stopped() const {
        if (stopped()) throw Stopped();
    }

    // Waits for this time; throws `Stopped` when it is cancelled.
    void sleep(std::chrono::milliseconds time) const {
        const auto end = (std::min)(deadline_, Clock::now() + time);
        if (state_) {
            std::unique_lock<std::mutex> lock(state_->mutex);
            state_->changed.wait_until(lock, end, [this] { return state_->stopped.load(); });
        } else {
            std::this_thread::sleep_until(end);
        }
        throw_if_stopped();
    }

private:
    friend class StopSource;

    bool has_deadline() const { return deadline_ != (Clock::time_point::max)(); }

    std::shared_ptr<detail::StopState> state_;
    Clock::time_point deadline_ = (Clock::time_point::max)();
};

// Cancels calls that have its token, from any thread, but not from a signal handler.
class StopSource {
public:
    StopToken token() const {
        StopToken token;
        token.state_ = state_;
        return token;
    }

    void stop() const {
        {
            const std::lock_guard<std::mutex> lock(state_->mutex);
            state_->stopped = true;
        }
        state_->changed.notify_all();
    }

    bool stopped() const { return state_->stopped; }

private:
    std::shared_ptr<detail::StopState> state_ = std::make_shared<detail::StopState>();
};

// ------------------------------------------------------------------------------------------------ Data

// The index of a data point or control point: {i}, or {row, column} of a surface.
using Index = std::vector<std::size_t>;

// Distances from the data points at their parameters, in data units; infinite where a weight is not positive.
struct Distances {
    double max = 0;
    double rms = 0;
    double sum = 0;
    Index at;                           // the data point with the largest distance
    std::optional<double> fixed_max;    // local fits: the largest one of the points that are not adjusted
    std::optional<double> homogeneous;  // homogeneous fits: the largest one in homogeneous coordinates
    std::optional<double> gradient;     // least squares: zero at the minimum
    std::optional<double> transformed;  // extended fits: the largest move of a control point in the next iteration
    std::optional<double> between;      // at the end: by how much the fit leaves its data between neighbours
};

// One direction of a fit: that of a curve, or u or v of a surface.
struct Direction {
    std::string basis;  // "bspline", "bernstein", "said_ball" or "wang_ball"
    int degree = 0;
    bool closed = false;             // periodic: the first control points are repeated at the end
    std::vector<double> knots;       // control points + degree + 1, as CAD kernels store them; empty for Ball bases
    std::vector<double> parameters;  // of the data points
};

// A control point of a homogeneous fit whose weight CAD kernels do not accept.
struct BadWeight {
    Index control_point;
    double weight = 0;
};

// A curve (one direction) or surface (two), with complete control points as CAD kernels store them.
struct Geometry {
    std::vector<Direction> directions;
    std::vector<double> control_points;  // row after row: shape[0] × … numbers; NaN where there is none
    std::vector<std::size_t> shape;      // {n, dimension}, or {rows, columns, dimension} of a surface
    std::vector<double> weights;         // one for each control point; empty if the fit has none
    std::optional<BadWeight> bad_weight;

    bool is_surface() const { return directions.size() == 2; }
    std::size_t dimension() const { return shape.empty() ? 0 : shape.back(); }
    int degree(std::size_t direction = 0) const { return directions.at(direction).degree; }
    const std::vector<double>& knots(std::size_t direction = 0) const { return directions.at(direction).knots; }
};

// Points at equal steps of the parameters, computed by the server.
struct Samples {
    std::vector<double> points;
    std::vector<std::size_t> shape;               // as that of control points
    std::vector<std::vector<double>> parameters;  // one list for each direction
};

// An iteration of a fit. Fields that were not requested from the stream are empty.
struct Iteration : Geometry {
    std::uint64_t number = 0;
    Distances error;
    std::optional<double> rate;              // the factor by which the step reduced the largest distance
    std::uint64_t moved = 0;                 // number of control points moved by the step
    std::optional<std::uint64_t> predicted;  // predicted total number of iterations
    std::optional<double> milestone;         // the smallest milestone first reached by this iteration
    Samples samples;                         // with view "samples"
};

// The region of a trimmed surface: the parameters to the left of all loops.
struct Trim {
    struct Face {
        std::size_t outer = 0;           // the loop around the piece
        std::vector<std::size_t> holes;  // the loops around its holes
    };

    double distance = 0;         // the largest distance of the outline from the data, in data units
    std::optional<double> area;  // of surfaces in the plane and in space
    std::vector<Geometry> loops;  // closed curves in (u, v); empty if nothing is trimmed off
    std::vector<Face> faces;
};

// The last iteration of a fit that has ended. It is within its tolerance if `state` is "converged".
struct Result : Geometry {
    std::string id;
    std::string name;
    std::string state;
    std::uint64_t iteration = 0;
    Distances error;
    std::optional<Trim> trim;
};

// The result of an item of a batch.
struct BatchItem {
    std::uint64_t index = 0;  // its index in the batch
    std::string name;
    std::string state;                       // "converged", "exhausted", "stalled" or "failed"
    std::optional<std::uint64_t> iteration;  // the last one
    std::optional<Distances> error;
    std::optional<Result> result;    // the last iteration, also of a fit that has not converged; without an id
    std::optional<Problem> problem;  // why it has not converged; pointers begin with /items/3 or /defaults
};

// How many items of a batch have ended.
struct BatchTotals {
    std::uint64_t items = 0;
    std::uint64_t converged = 0;
    std::uint64_t failed = 0;  // those that have not converged
};

// The end of a job.
struct End {
    std::string id;
    std::string state;   // "converged", "exhausted", "stalled", "failed" or "cancelled"
    std::string reason;  // the reason, if the state does not determine it, such as "minimum"
    std::string detail;  // the reason as text, with the remaining distance
    std::uint64_t iterations = 0;
    std::optional<Distances> error;
    std::optional<double> elapsed;  // seconds
    std::optional<Problem> problem;
};

// A warning about a fit that is computed nevertheless.
struct Warning {
    std::string code;
    std::string pointer;
    std::string detail;
};

// The job that an edit started from.
struct Parent {
    std::string id;
    std::uint64_t iteration = 0;
};

// A snapshot of a job.
struct JobStatus {
    std::string id;
    std::string name;
    std::string kind;   // "curve" or "surface"
    std::string state;  // "queued", "running", or one of `End`
    std::string reason;
    std::string detail;
    std::vector<Warning> warnings;
    std::optional<std::uint64_t> iteration;
    std::optional<Distances> error;
    double progress = 0;  // from 0 to 1
    std::optional<Parent> parent;
    std::optional<Problem> problem;  // why it failed
    Json json;                       // the complete JSON of the server

    bool ended() const { return state != "queued" && state != "running"; }
};

// Distances of the data from the nearest points of the curve or surface.
struct Deviation {
    std::uint64_t iteration = 0;
    double max = 0;
    double rms = 0;
    Index at;
    std::map<int, double> percentiles;  // of 50, 90, 95 and 99 per cent
    std::vector<double> distances;      // of each data point, if requested; NaN for a missing one
    std::vector<double> between;        // likewise, the deviation in each gap between data points
};

// An exported file of a result or iteration, such as STEP.
struct File {
    std::string name;  // as the server suggests it, such as "wing.step"
    std::string media_type;
    std::string content;
};

// --------------------------------------------------------------------------------------------- Options

// Connection settings.
struct ClientOptions {
    // A token of `piad token create`, for a server that requires one.
    std::string token;
    // The maximum number of times a request is sent, or a stream is opened without receiving an iteration, while
    // connections break or the server is overloaded. A server that has never responded is tried three times.
    int attempts = 8;
    // The longest silence of the server; for streams at least 60 seconds.
    std::chrono::milliseconds timeout{60000};
    // The timeout for opening a connection.
    std::chrono::milliseconds connect_timeout{5000};
    // Header lines of each request, such as "X-Team: wings".
    std::vector<std::string> headers;
    // Called for each transfer after its options are set, to configure proxies, certificates or a Unix domain socket.
    std::function<void(CURL*)> configure;
};

// Options of requests for a new job.
struct CreateOptions {
    // The key by which the server recognises a retry. Random if empty; a program that may itself restart should set it.
    std::string idempotency_key;
    // How long the server may wait for the end of the job before it responds.
    std::chrono::seconds wait{0};
    StopToken stop;
};

// Stream settings: see docs/reference/events.md. Omitted ones are those of the job.
struct WatchOptions {
    std::string view;                    // "control_points", "samples" or "errors"
    std::string samples;                 // "200", or "40x40" of a surface
    std::uint64_t every = 0;             // only multiples of this number, and the last
    std::vector<double> milestones;      // decreasing distances: only the first iteration within each, and the last
    std::string pace;                    // "latest": a slow reader skips to the newest iteration
    std::string encoding;                // "base64" where that is allowed, otherwise "json"; "delta" takes a tenth of the bytes
    std::string digits;                  // "auto": only as many digits as the error justifies
    bool changed = false;                // send only control points that moved; iterations are complete even so
    std::optional<std::uint64_t> after;  // begin after this iteration
    StopToken stop;
    // Called with the `job` event of each connection, which has the predicted number of iterations, for example. If it
    // says "resumed": "restarted", the server was replaced and sends all iterations again.
    std::function<void(const Json&)> on_job;

    // Streams of new jobs and edits only:
    std::string on_disconnect;  // "cancel": the job is cancelled when its connection closes
    std::string idempotency_key;
    // The iteration that an edit starts from: its knots are then not sent again, and with `changed` the first
    // event of an ephemeral edit is relative to it.
    const Iteration* from = nullptr;
};

// Options of batches.
struct BatchOptions {
    Json defaults;  // job fields for items that do not set them
    StopToken stop;
};

// Options of job lists.
struct ListOptions {
    std::string state;        // only those in this state
    std::size_t limit = 100;  // at most this many, the newest
    StopToken stop;
};

// Options of exported files.
struct FileOptions {
    std::optional<std::uint64_t> iteration;  // instead of the result
    std::string samples;                     // of gltf, stl, ply, dxf, svg, geojson, gpx and csv
    std::string units;                       // "mm", "m" or "in": what step and iges declare
    std::string dots;                        // "on" or "off": shows data points in svg
    StopToken stop;
};

using Query = std::vector<std::pair<std::string, std::string>>;

namespace detail {

// ------------------------------------------------------------------------------------- Numbers and JSON

inline double number(const Json& value, double otherwise = std::numeric_limits<double>::quiet_NaN()) {
    return value.is_null() ? otherwise : value.get<double>();
}

// The value of a field, or nullopt if it is absent or null.
template <class T>
std::optional<T> field(const Json& object, const char* name) {
    const auto found = object.find(name);
    if (found == object.end() || found->is_null()) return std::nullopt;
    return found->get<T>();
}

inline std::string text(const Json& object, const char* name) { return field<std::string>(object, name).value_or(""); }

// Calls `read`, which parses a response; missing fields throw ProtocolError.
template <class Read>
auto reading(const Read& read) {
    try {
        return read();
    } catch (const Json::exception& error) {
        throw ProtocolError(std::string("the server answered something unexpected: ") + error.what());
    }
}

inline Json parse(const std::string& text) {
    return reading([&] {
        Json value = Json::parse(text);
        if (!value.is_object()) throw ProtocolError("the server did not answer a JSON object");
        return value;
    });
}

// The JSON pointer of the first number that is not finite; empty if all are.
inline std::string not_finite(const Json& value, const std::string& pointer) {
    if (value.is_number_float() && !std::isfinite(value.get<double>())) return pointer.empty() ? "/" : pointer;
    if (!value.is_structured()) return "";
    for (auto item = value.begin(); item != value.end(); ++item) {
        // Most values are coordinates, so a pointer is built only when needed.
        if (!item->is_structured() && !(item->is_number_float() && !std::isfinite(item->get<double>()))) continue;
        const auto key = value.is_object() ? item.key() : std::to_string(std::distance(value.begin(), item));
        auto found = not_finite(*item, pointer + "/" + key);
        if (!found.empty()) return found;
    }
    return "";
}

inline std::string encoded(const Json& body) {
    const auto pointer = not_finite(body, "");
    if (!pointer.empty()) throw std::invalid_argument("the number at " + pointer + " is not finite");
    try {
        return body.dump();
    } catch (const Json::exception& error) {
        throw std::invalid_argument(std::string("the request cannot be written as JSON: ") + error.what());
    }
}

constexpr std::array<std::int8_t, 256> base64_digits() {
    std::array<std::int8_t, 256> digits{};
    for (auto& digit : digits) digit = -1;
    const char alphabet[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (int i = 0; i < 64; ++i) digits[static_cast<unsigned char>(alphabet[i])] = static_cast<std::int8_t>(i);
    return digits;
}

inline constexpr std::array<std::int8_t, 256> base64_table = base64_digits();

// Decodes base64 (standard alphabet, padded).
class Base64 {
public:
    // Calls `on_byte` for each byte.
    template <class OnByte>
    static void bytes(const std::string& text, const OnByte& on_byte) {
        std::size_t length = text.size();
        if (length % 4 != 0) throw ProtocolError("base64 of the server is not padded");
        while (length > 0 && text.size() - length < 2 && text[length - 1] == '=') --length;
        std::uint32_t pending = 0;  // bits of an incomplete byte
        unsigned pending_bits = 0;
        for (std::size_t i = 0; i < length; ++i) {
            const int digit = base64_table[static_cast<unsigned char>(text[i])];
            if (digit < 0) throw ProtocolError("base64 of the server has a character that is none of base64");
            pending = (pending << 6 | static_cast<std::uint32_t>(digit)) & 0xffff;
            pending_bits += 6;
            if (pending_bits < 8) continue;
            pending_bits -= 8;
            on_byte(pending >> pending_bits & 0xff);
        }
    }

    // Little-endian floating-point numbers.
    template <class Float, class Bits>
    static void read(const std::string& text, std::vector<double>& out) {
        static_assert(sizeof(Float) == sizeof(Bits), "the bits of a number");
        out.clear();
        out.reserve(text.size() * 3 / 4 / sizeof(Float));
        Bits bits = 0;
        unsigned filled = 0;  // bits of the number so far
        bytes(text, [&](std::uint32_t byte) {
            bits |= static_cast<Bits>(byte) << filled;
            filled += 8;
            if (filled < 8 * sizeof(Bits)) return;
            Float value;
            std::memcpy(&value, &bits, sizeof value);
            out.push_back(static_cast<double>(value));
            bits = 0;
            filled = 0;
        });
        if (filled != 0) throw ProtocolError("base64 of the server ends within a number");
    }
};

inline void flatten(const Json& value, std::vector<double>& out) {
    if (!value.is_array()) return out.push_back(number(value));
    for (const auto& part : value) flatten(part, out);
}

// Numbers as nested lists or as base64, of 32 bits if `single`. Null is an empty list.
inline void read_numbers(const Json& value, bool single, std::vector<double>& out) {
    out.clear();
    if (value.is_null()) return;
    if (!value.is_string()) return flatten(value, out);
    const auto& text = value.get_ref<const std::string&>();
    single ? Base64::read<float, std::uint32_t>(text, out) : Base64::read<double, std::uint64_t>(text, out);
}

inline std::vector<double> numbers(const Json& value, bool single = false) {
    std::vector<double> out;
    read_numbers(value, single, out);
    return out;
}

// Adds `step` times packed integers to points: see docs/reference/events.md. `packed` is a reused buffer.
inline void move_numbers(const Json& value, double step, std::size_t dimension, std::vector<std::uint8_t>& packed, std::vector<double>& out) {
    packed.clear();
    Base64::bytes(value.get_ref<const std::string&>(), [&](std::uint32_t byte) { packed.push_back(static_cast<std::uint8_t>(byte)); });
    const std::size_t places = dimension == 0 ? 0 : out.size() / dimension;
    std::size_t at = 0;
    for (std::size_t coordinate = 0; coordinate < dimension; ++coordinate) {
        for (std::size_t start = 0; start < places; start += 256) {
            const std::size_t end = std::min<std::size_t>(start + 256, places);
            const unsigned width = at < packed.size() ? packed[at] : 33;
            std::size_t next = at + 1;
            at = next + ((end - start) * width + 7) / 8;
            if (width > 32 || at > packed.size()) throw ProtocolError("the server sent packed numbers that are cut off or too wide");
            const std::uint64_t mask = (std::uint64_t{1} << width) - 1;
            std::uint64_t bits = 0;
            unsigned filled = 0;
            for (std::size_t place = start; place < end; ++place) {
                for (; filled < width; filled += 8) bits |= std::uint64_t{packed[next++]} << filled;
                const auto z = static_cast<std::int64_t>(bits & mask);
                bits >>= width;
                filled -= width;
                out[place * dimension + coordinate] += step * static_cast<double>((z >> 1) ^ -(z & 1));
            }
        }
    }
    if (at != packed.size()) throw ProtocolError("the server sent more packed numbers than there are");
}

inline bool is_single(const Json& event) { return text(event, "encoding") == "base64_f32"; }

// An array of points with its shape, which is given by the nesting of JSON or separately for base64.
inline void read_points(const Json& event, const char* name, std::vector<double>& out, std::vector<std::size_t>& shape) {
    const Json& value = event.at(name);
    read_numbers(value, is_single(event), out);
    shape.clear();
    if (value.is_string()) {
        shape = event.at("shape").get<std::vector<std::size_t>>();
    } else {
        for (const Json* part = &value; part->is_array(); part = &part->front()) {
            shape.push_back(part->size());
            if (part->empty()) break;
        }
    }
    std::size_t count = 1;
    for (const std::size_t length : shape) count *= length;
    if (count != out.size()) throw ProtocolError(std::string("the numbers of ") + name + " are not as many as their shape says");
}

inline Index read_index(const Json& value) {
    if (value.is_array()) return value.get<Index>();
    return {value.get<std::size_t>()};
}

inline Distances read_distances(const Json& value) {
    constexpr double infinite = std::numeric_limits<double>::infinity();
    Distances distances;
    distances.max = number(value.at("max"), infinite);
    distances.rms = number(value.at("rms"), infinite);
    distances.sum = number(value.at("sum"), infinite);
    distances.at = read_index(value.at("at"));
    distances.fixed_max = field<double>(value, "fixed_max");
    distances.homogeneous = field<double>(value, "homogeneous");
    distances.gradient = field<double>(value, "gradient");
    distances.transformed = field<double>(value, "transformed");
    distances.between = field<double>(value, "between");
    return distances;
}

inline std::optional<Distances> read_error(const Json& value) {
    const auto found = value.find("error");
    if (found == value.end() || found->is_null()) return std::nullopt;
    return read_distances(*found);
}

inline Problem read_problem(const Json& value) {
    Problem problem;
    problem.type = field<std::string>(value, "type").value_or("about:blank");
    problem.title = text(value, "title");
    problem.status = field<int>(value, "status").value_or(0);
    problem.detail = text(value, "detail");
    problem.request_id = text(value, "request_id");
    for (const auto& error : value.value("errors", Json::array())) {
        FieldError one{text(error, "detail"), text(error, "pointer"), text(error, "parameter"), text(error, "header"), 0};
        one.line = field<std::uint64_t>(error, "line").value_or(0);
        if (!one.pointer.empty()) problem.pointers.push_back(one.pointer);
        problem.errors.push_back(std::move(one));
    }
    return problem;
}

inline std::optional<Problem> read_problem_of(const Json& job) {
    const auto found = job.find("problem");
    if (found == job.end() || found->is_null()) return std::nullopt;
    return read_problem(*found);
}

inline std::optional<BadWeight> read_bad_weight(const Json& value) {
    const auto found = value.find("bad_weight");
    if (found == value.end() || found->is_null()) return std::nullopt;
    return BadWeight{read_index(found->at("control_point")), number(found->at("weight"))};
}

inline JobStatus read_status(Json value) {
    return reading([&] {
        JobStatus status;
        status.id = value.at("id").get<std::string>();
        status.name = text(value, "name");
        status.kind = value.at("kind").get<std::string>();
        status.state = value.at("state").get<std::string>();
        status.reason = text(value, "reason");
        status.detail = text(value, "detail");
        for (const auto& one : value.value("warnings", Json::array())) {
            status.warnings.push_back({text(one, "code"), text(one, "pointer"), text(one, "detail")});
        }
        status.iteration = field<std::uint64_t>(value, "iteration");
        status.error = read_error(value);
        status.progress = value.at("progress").get<double>();
        if (const auto parent = field<Json>(value, "parent")) {
            status.parent = Parent{parent->at("id").get<std::string>(), parent->at("iteration").get<std::uint64_t>()};
        }
        status.problem = read_problem_of(value);
        status.json = std::move(value);
        return status;
    });
}

inline End read_end(const Json& value, const std::string& id) {
    return reading([&] {
        End end;
        end.id = id;
        end.state = value.at("state").get<std::string>();
        end.reason = text(value, "reason");
        end.detail = text(value, "detail");
        end.iterations = value.at("iterations").get<std::uint64_t>();
        end.error = read_error(value);
        end.elapsed = field<double>(value, "elapsed");
        end.problem = read_problem_of(value);
        return end;
    });
}

// The names of the directions of a surface; a curve has one without a name.
inline std::vector<const char*> direction_names(const Json& value) {
    if (value.at("kind") == "curve") return {nullptr};
    return {"u", "v"};
}

inline const Json& part(const Json& value, const char* name, const char* direction) {
    return direction == nullptr ? value.at(name) : value.at(name).at(direction);
}

inline std::vector<Direction> read_directions(const Json& value) {
    std::vector<Direction> directions;
    for (const char* name : direction_names(value)) {
        Direction one;
        one.basis = part(value, "basis", name).get<std::string>();
        one.degree = part(value, "degree", name).get<int>();
        one.closed = part(value, "closed", name).get<bool>();
        // Knots are 64-bit numbers in each encoding, since 32 bits may not separate neighbours.
        one.knots = numbers(part(value, "knots", name));
        one.parameters = numbers(part(value, "parameters", name));
        directions.push_back(std::move(one));
    }
    return directions;
}

// Fixed weights of all control points. Those of surfaces are products; a direction may lack them.
inline std::vector<double> read_fixed_weights(const Json& value, const std::vector<std::size_t>& counts) {
    const auto names = direction_names(value);
    std::vector<double> product{1.0};
    for (std::size_t i = 0; i < names.size(); ++i) {
        auto factors = numbers(part(value, "weights", names[i]));
        if (factors.empty()) factors.assign(counts.at(i), 1.0);
        std::vector<double> next;
        next.reserve(product.size() * factors.size());
        for (const double left : product) {
            for (const double right : factors) next.push_back(left * right);
        }
        product = std::move(next);
    }
    return product;
}

inline Trim read_trim(const Json& value) {
    Trim trim;
    trim.distance = value.at("distance").get<double>();
    trim.area = field<double>(value, "area");
    for (const Json& it : value.at("loops")) {
        Direction direction;
        direction.basis = "bspline";
        direction.degree = it.at("degree").get<int>();
        direction.closed = true;
        direction.knots = it.at("knots").get<std::vector<double>>();
        Geometry loop;
        loop.directions.push_back(std::move(direction));
        read_points(it, "control_points", loop.control_points, loop.shape);
        trim.loops.push_back(std::move(loop));
    }
    for (const Json& it : value.at("faces")) {
        trim.faces.push_back({it.at("outer").get<std::size_t>(), it.at("holes").get<std::vector<std::size_t>>()});
    }
    return trim;
}

inline Result read_result(const Json& value) {
    return reading([&] {
        Result result;
        result.id = text(value, "id");
        result.name = text(value, "name");
        result.state = value.at("state").get<std::string>();
        result.iteration = value.at("iteration").get<std::uint64_t>();
        result.error = read_distances(value.at("error"));
        result.directions = read_directions(value);
        result.bad_weight = read_bad_weight(value);
        read_points(value, "control_points", result.control_points, result.shape);
        const auto rational = text(value, "rational");
        if (rational == "fixed") result.weights = read_fixed_weights(value, result.shape);
        if (rational == "homogeneous") read_numbers(value.at("weights"), is_single(value), result.weights);
        if (value.contains("trim")) result.trim = read_trim(value.at("trim"));
        return result;
    });
}

// Replaces the index of the item in its request by that in the batch.
inline Problem moved(Problem problem, const std::string& own, const std::string& place) {
    const auto ends = [](char c) { return c == '/' || c == ':'; };
    for (auto at = problem.detail.find(own); at != std::string::npos; at = problem.detail.find(own, at + 1)) {
        const auto behind = at + own.size();
        if (behind < problem.detail.size() && ends(problem.detail[behind])) {
            problem.detail.replace(at, own.size(), place);
            at += place.size() - 1;
        }
    }
    const auto move = [&](std::string& pointer) {
        const bool is_below = pointer.compare(0, own.size(), own) == 0 && (pointer.size() == own.size() || pointer[own.size()] == '/');
        if (is_below) pointer.replace(0, own.size(), place);
    };
    for (auto& error : problem.errors) move(error.pointer);
    for (auto& pointer : problem.pointers) move(pointer);
    return problem;
}

// Parses the line of an item; the request began with item `first`.
inline BatchItem read_batch_item(const Json& value, std::uint64_t first) {
    return reading([&] {
        BatchItem item;
        const auto own = value.at("index").get<std::uint64_t>();
        item.index = first + own;
        item.name = text(value, "name");
        item.state = value.at("state").get<std::string>();
        item.iteration = field<std::uint64_t>(value, "iteration");
        item.error = read_error(value);
        for (const char* kind : {"curve", "surface"}) {
            const auto geometry = value.find(kind);
            if (geometry == value.end()) continue;
            Json result = *geometry;
            result["kind"] = kind;
            for (const char* name : {"name", "state", "iteration", "error"}) {
                if (value.contains(name)) result[name] = value.at(name);
            }
            item.result = read_result(result);
        }
        if (const auto problem = value.find("problem"); problem != value.end()) {
            item.problem = moved(read_problem(*problem), "/items/" + std::to_string(own), "/items/" + std::to_string(item.index));
        }
        return item;
    });
}

// Converts events to iterations, in one object whose memory is reused.
class IterationReader {
public:
    IterationReader() = default;
    explicit IterationReader(const Iteration* from) {
        if (from != nullptr) current_ = *from;
    }

    void job(const Json& event) {
        // An event without bases belongs to an edit, which has the knots and weights of its parent.
        if (!event.contains("knots")) return;
        current_.directions = read_directions(event);
        if (text(event, "rational") != "fixed") return current_.weights.clear();
        std::vector<std::size_t> counts;
        for (const char* name : direction_names(event)) counts.push_back(part(event, "control_points", name).get<std::size_t>());
        current_.weights = read_fixed_weights(event, counts);
    }

    const Iteration& iteration(const Json& event) {
        current_.number = event.at("iteration").get<std::uint64_t>();
        current_.error = read_distances(event.at("error"));
        current_.rate = field<double>(event, "rate");
        current_.moved = event.at("moved").get<std::uint64_t>();
        current_.predicted = field<std::uint64_t>(event, "predicted");
        current_.milestone = field<double>(event, "milestone");
        current_.bad_weight = read_bad_weight(event);
        read_knots(event);
        if (event.contains("changed")) apply(event.at("changed"));
        if (text(event, "encoding") == "delta") return move(event);
        if (event.contains("samples")) read_samples(event);
        if (event.contains("control_points")) {
            read_points(event, "control_points", current_.control_points, current_.shape);
            if (event.contains("weights")) read_numbers(event.at("weights"), is_single(event), current_.weights);
        }
        return current_;
    }

private:
    // Fits that choose their knots send them with each iteration that changes them.
    void read_knots(const Json& event) {
        const auto found = event.find("knots");
        if (found == event.end() || found->is_null()) return;
        const bool surface = found->is_object();
        if (current_.directions.size() != (surface ? 2u : 1u)) throw ProtocolError("the server sent knots before the job");
        read_numbers(surface ? found->at("u") : *found, false, current_.directions[0].knots);
        if (surface) read_numbers(found->at("v"), false, current_.directions[1].knots);
    }

    void read_samples(const Json& event) {
        auto& samples = current_.samples;
        read_points(event, "samples", samples.points, samples.shape);
        const Json& parameters = event.at("parameters");
        samples.parameters.clear();
        if (parameters.is_object()) {
            samples.parameters = {numbers(parameters.at("u"), is_single(event)), numbers(parameters.at("v"), is_single(event))};
        } else {
            samples.parameters = {numbers(parameters, is_single(event))};
        }
    }

    // Adds differences to the previous numbers.
    const Iteration& move(const Json& event) {
        const auto shape = event.at("shape").get<std::vector<std::size_t>>();
        const double step = event.at("step").get<double>();
        const bool samples = event.contains("samples");
        if (shape.empty() || shape != (samples ? current_.samples.shape : current_.shape)) {
            throw ProtocolError("the server sent changes before what has changed");
        }
        auto& points = samples ? current_.samples.points : current_.control_points;
        move_numbers(event.at(samples ? "samples" : "control_points"), step, shape.back(), packed_, points);
        if (event.contains("weights")) {
            move_numbers(event.at("weights"), event.at("weight_step").get<double>(), 1, packed_, current_.weights);
        }
        return current_;
    }

    // Overwrites control points that have moved: [[index, point], …] or [[index, point, weight], …].
    void apply(const Json& changes) {
        const std::size_t dimension = current_.dimension();
        for (const auto& change : changes) {
            const Index index = read_index(change.at(0));
            const auto point = numbers(change.at(1));
            const std::size_t place = index.size() == 2 && current_.shape.size() == 3 ? index[0] * current_.shape[1] + index[1] : index[0];
            if (point.size() != dimension || (place + 1) * dimension > current_.control_points.size()) {
                throw ProtocolError("the server changed a control point that is not there");
            }
            std::copy(point.begin(), point.end(), current_.control_points.begin() + static_cast<std::ptrdiff_t>(place * dimension));
            if (change.size() < 3) continue;
            if (place >= current_.weights.size()) throw ProtocolError("the server changed a weight that is not there");
            current_.weights[place] = number(change.at(2));
        }
    }

    Iteration current_;
    std::vector<std::uint8_t> packed_;
};

// --------------------------------------------------------------------------------- Server-sent events

struct Event {
    std::string name;
    std::string data;
    std::string id;
};

// Parses the part of server-sent events (WHATWG HTML, section 9.2) that this API uses. Buffers one event at most.
class EventParser {
public:
    // Calls `on_event` for each complete event, until it returns false.
    template <class OnEvent>
    bool feed(const char* data, std::size_t size, const OnEvent& on_event) {
        while (size > 0) {
            const auto* end = static_cast<const char*>(std::memchr(data, '\n', size));
            const std::size_t length = end == nullptr ? size : static_cast<std::size_t>(end - data);
            line_.append(data, length);
            if (end == nullptr) return true;
            data += length + 1;
            size -= length + 1;
            if (!line_.empty() && line_.back() == '\r') line_.pop_back();
            const bool go_on = take_line(on_event);
            line_.clear();
            if (!go_on) return false;
        }
        return true;
    }

    // The delay before reopening the stream, in seconds, requested by the server.
    double retry() const { return retry_; }

    // Drops an event that is incomplete at the end of a connection.
    void reset() {
        line_.clear();
        event_ = {};
        has_data_ = false;
    }

private:
    template <class OnEvent>
    bool take_line(const OnEvent& on_event) {
        if (line_.empty()) {
            const bool complete = std::exchange(has_data_, false);
            const Event event = std::exchange(event_, {});
            return !complete || on_event(event);
        }
        const std::string_view line(line_);
        const auto colon = line.find(':');
        const auto name = line.substr(0, colon);
        auto value = colon == std::string_view::npos ? std::string_view() : line.substr(colon + 1);
        if (!value.empty() && value.front() == ' ') value.remove_prefix(1);
        if (name == "data") {
            if (has_data_) event_.data += '\n';
            event_.data += value;
            has_data_ = true;
        } else if (name == "event") {
            event_.name = value;
        } else if (name == "id") {
            event_.id = value;
        } else if (name == "retry" && !value.empty() && value.size() < 9 && value.find_first_not_of("0123456789") == std::string_view::npos) {
            retry_ = (std::min)(std::stod(std::string(value)) / 1000, 60.0);
        }
        return true;
    }

    std::string line_;
    Event event_;
    bool has_data_ = false;
    double retry_ = 2.0;
};

// ------------------------------------------------------------------------------------------- Transfers

// A request. `accepted_again` is a status that, for a retry, means that an earlier attempt succeeded but its response
// was lost.
struct Call {
    std::string method = "GET";
    std::string path;
    Query query;
    std::string accept = "application/json";
    std::string content_type;  // empty: no body
    std::string body;
    std::vector<std::string> headers;
    int accepted_again = 0;
    StopToken stop;
};

struct Answer {
    int status = 0;
    std::string media_type;
    std::string file_name;
    std::string body;
};

// Receives a chunk of the body; returns false to stop.
using Sink = std::function<bool(const char*, std::size_t)>;

inline void initialise_curl() {
    static const CURLcode code = curl_global_init(CURL_GLOBAL_DEFAULT);
    if (code != CURLE_OK) throw Error(std::string("libcurl cannot start: ") + curl_easy_strerror(code));
}

// A libcurl handle with its open connections.
class CurlHandle {
public:
    CurlHandle() : easy(curl_easy_init()), multi(curl_multi_init()) {
        if (easy == nullptr || multi == nullptr) {
            close();
            throw Error("libcurl has no memory for a handle");
        }
    }
    ~CurlHandle() { close(); }
    CurlHandle(const CurlHandle&) = delete;
    CurlHandle& operator=(const CurlHandle&) = delete;

    CURL* const easy;
    CURLM* const multi;

private:
    void close() {
        curl_easy_cleanup(easy);
        if (multi != nullptr) curl_multi_cleanup(multi);
    }
};

// Idle handles: each transfer uses its own, so that threads do not wait for each other.
class HandlePool {
public:
    std::unique_ptr<CurlHandle> take() {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (idle_.empty()) return std::make_unique<CurlHandle>();
        auto handle = std::move(idle_.back());
        idle_.pop_back();
        return handle;
    }

    void give_back(std::unique_ptr<CurlHandle> handle) {
        curl_easy_reset(handle->easy);
        const std::lock_guard<std::mutex> lock(mutex_);
        if (idle_.size() < 8) idle_.push_back(std::move(handle));
    }

private:
    std::mutex mutex_;
    std::vector<std::unique_ptr<CurlHandle>> idle_;
};

inline std::string escaped(const std::string& text) {
    static const char hex[] = "0123456789ABCDEF";
    std::string out;
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        const bool plain = (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || std::strchr("-._~", c) != nullptr;
        if (plain && c != '\0') {
            out += c;
        } else {
            out += {'%', hex[byte >> 4], hex[byte & 15]};
        }
    }
    return out;
}

// Checks a header line, which must not contain a line feed.
inline const std::string& header_line(const std::string& line) {
    const bool control = std::any_of(line.begin(), line.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; });
    if (control) throw std::invalid_argument("a token, key or header has a character that cannot be sent");
    return line;
}

// One request and its response. The body of a successful response is passed to the sink, if there is one, in libcurl's
// write callback: nothing more is read while the sink is busy, which holds back the server.
class Transfer {
public:
    using Clock = StopToken::Clock;

    Transfer(CurlHandle& handle, const ClientOptions& options, const std::string& url, const Call& call, const Sink& sink)
        : easy_(handle.easy), multi_(handle.multi), call_(call), sink_(sink) {
        silence_ = sink ? (std::max)(options.timeout, std::chrono::milliseconds(60000)) : options.timeout;
        add_headers(options);
        set_up(options, url);
    }
    ~Transfer() {
        if (added_) curl_multi_remove_handle(multi_, easy_);
    }
    Transfer(const Transfer&) = delete;
    Transfer& operator=(const Transfer&) = delete;

    // The response, with any status. `*answered` is set when the server has sent anything.
    Answer perform(std::atomic<bool>& answered) {
        call_.stop.throw_if_stopped();
        touched_ = Clock::now();
        if (curl_multi_add_handle(multi_, easy_) != CURLM_OK) throw Error("libcurl takes no further transfer");
        added_ = true;
        const CURLcode code = run();
        answer_.status = status();
        if (answer_.status != 0) answered = true;
        if (thrown_) std::rethrow_exception(thrown_);
        if (!enough_ && code != CURLE_OK) fail(code);
        if (sink_ && answer_.status / 100 == 2 && !is_expected_type()) {
            throw ProtocolError("the server did not answer with " + call_.accept);
        }
        const char* type = nullptr;
        curl_easy_getinfo(easy_, CURLINFO_CONTENT_TYPE, &type);
        if (type != nullptr) answer_.media_type = type;
        return std::move(answer_);
    }

    // Parses Retry-After, which may be a date, as seconds.
    std::optional<double> retry_after() const {
        curl_off_t seconds = 0;
        curl_easy_getinfo(easy_, CURLINFO_RETRY_AFTER, &seconds);
        if (seconds <= 0) return std::nullopt;
        return static_cast<double>(seconds);
    }

private:
    void add_header(const std::string& line) {
        curl_slist* const longer = curl_slist_append(headers_.get(), line.c_str());
        if (longer == nullptr) throw std::bad_alloc();
        static_cast<void>(headers_.release());
        headers_.reset(longer);
    }

    void add_headers(const ClientOptions& options) {
        add_header("Accept: " + call_.accept);
        // Without this, libcurl would send an empty body as a form.
        add_header("Content-Type:" + (call_.content_type.empty() ? "" : " " + call_.content_type));
        if (!options.token.empty()) add_header("Authorization: Bearer " + options.token);
        for (const auto& line : options.headers) add_header(line);
        for (const auto& line : call_.headers) add_header(line);
    }

    template <class Value>
    void set(CURLoption option, Value value) {
        const CURLcode code = curl_easy_setopt(easy_, option, value);
        if (code != CURLE_OK) throw Error(std::string("libcurl refuses an option: ") + curl_easy_strerror(code));
    }

    void set_up(const ClientOptions& options, const std::string& url) {
        set(CURLOPT_URL, url.c_str());
        // HTTP/2 streams have windows of megabytes; with HTTP/1.1 only the kernel's buffers are read ahead.
        set(CURLOPT_HTTP_VERSION, static_cast<long>(CURL_HTTP_VERSION_1_1));
        set(CURLOPT_NOSIGNAL, 1L);
        set(CURLOPT_USERAGENT, "piad-cpp");
        set(CURLOPT_CONNECTTIMEOUT_MS, static_cast<long>(options.connect_timeout.count()));
        set(CURLOPT_HTTPHEADER, headers_.get());
        set(CURLOPT_ERRORBUFFER, message_);
        set(CURLOPT_WRITEFUNCTION, &Transfer::on_body);
        set(CURLOPT_WRITEDATA, static_cast<void*>(this));
        set(CURLOPT_HEADERFUNCTION, &Transfer::on_header);
        set(CURLOPT_HEADERDATA, static_cast<void*>(this));
        set(CURLOPT_XFERINFOFUNCTION, &Transfer::on_progress);
        set(CURLOPT_XFERINFODATA, static_cast<void*>(this));
        set(CURLOPT_NOPROGRESS, 0L);
        if (call_.method == "POST") {
            set(CURLOPT_POST, 1L);
            set(CURLOPT_POSTFIELDS, call_.body.c_str());
            set(CURLOPT_POSTFIELDSIZE_LARGE, static_cast<curl_off_t>(call_.body.size()));
        } else if (call_.method != "GET") {
            set(CURLOPT_CUSTOMREQUEST, call_.method.c_str());
        }
        if (options.configure) options.configure(easy_);
    }

    CURLcode run() {
        // The interval of checking the token while nothing arrives.
        const int pause = call_.stop.possible() ? 50 : 500;
        for (;;) {
            int running = 0;
            if (curl_multi_perform(multi_, &running) != CURLM_OK) throw Error("libcurl cannot continue a transfer");
            int left = 0;
            while (const CURLMsg* message = curl_multi_info_read(multi_, &left)) {
                if (message->msg == CURLMSG_DONE) return message->data.result;
            }
            call_.stop.throw_if_stopped();
            if (Clock::now() - touched_ > silence_) throw ConnectionLost("the server was silent for " + std::to_string(silence_.count() / 1000) + " s");
            curl_multi_poll(multi_, nullptr, 0, pause, nullptr);
        }
    }

    [[noreturn]] void fail(CURLcode code) const {
        const std::string why = message_[0] == '\0' ? curl_easy_strerror(code) : message_;
        switch (code) {
            case CURLE_UNSUPPORTED_PROTOCOL:
            case CURLE_WEIRD_SERVER_REPLY:
                throw ProtocolError("the server does not speak HTTP/1.1: " + why);
            case CURLE_OUT_OF_MEMORY:
                throw std::bad_alloc();
            case CURLE_PEER_FAILED_VERIFICATION:
            case CURLE_SSL_CACERT_BADFILE:
            case CURLE_SSL_CERTPROBLEM:
                throw ConnectionLost(why, true);
            default:
                throw ConnectionLost(why);
        }
    }

    int status() const {
        long status = 0;
        curl_easy_getinfo(easy_, CURLINFO_RESPONSE_CODE, &status);
        return static_cast<int>(status);
    }

    bool is_expected_type() const {
        const char* type = nullptr;
        curl_easy_getinfo(easy_, CURLINFO_CONTENT_TYPE, &type);
        return type != nullptr && std::strncmp(type, call_.accept.c_str(), call_.accept.size()) == 0;
    }

    // Exceptions must not pass through libcurl: they are rethrown after it returns.
    std::size_t take(const char* data, std::size_t size) {
        try {
            call_.stop.throw_if_stopped();
            if (!sink_ || status() / 100 != 2 || !is_expected_type()) {
                answer_.body.append(data, size);
            } else {
                enough_ = !sink_(data, size);
            }
            call_.stop.throw_if_stopped();
        } catch (...) {
            thrown_ = std::current_exception();
        }
        touched_ = Clock::now();
        return thrown_ || enough_ ? 0 : size;
    }

    static std::size_t on_body(char* data, std::size_t, std::size_t size, void* self) {
        return static_cast<Transfer*>(self)->take(data, size);
    }

    static std::size_t on_header(char* data, std::size_t, std::size_t size, void* self) {
        auto& transfer = *static_cast<Transfer*>(self);
        transfer.touched_ = Clock::now();
        const std::string_view line(data, size);
        constexpr std::string_view name = "content-disposition:";
        const auto same = [](char a, char b) { return (a >= 'A' && a <= 'Z' ? a + 32 : a) == b; };
        if (line.size() > name.size() && std::equal(name.begin(), name.end(), line.begin(), [&](char b, char a) { return same(a, b); })) {
            transfer.take_file_name(line);
        }
        return size;
    }

    void take_file_name(std::string_view line) {
        constexpr std::string_view mark = "filename=\"";
        const auto begin = line.find(mark);
        if (begin == std::string_view::npos) return;
        line.remove_prefix(begin + mark.size());
        answer_.file_name = line.substr(0, line.find('"'));
    }

    // Sending counts as progress, like receiving.
    static int on_progress(void* self, curl_off_t, curl_off_t received, curl_off_t, curl_off_t sent) {
        auto& transfer = *static_cast<Transfer*>(self);
        if (std::exchange(transfer.moved_, received + sent) != received + sent) transfer.touched_ = Clock::now();
        return 0;
    }

    CURL* easy_;
    CURLM* multi_;
    const Call& call_;
    const Sink& sink_;
    std::chrono::milliseconds silence_{0};
    std::unique_ptr<curl_slist, decltype(&curl_slist_free_all)> headers_{nullptr, &curl_slist_free_all};
    bool added_ = false;
    bool enough_ = false;
    Answer answer_;
    std::exception_ptr thrown_;
    Clock::time_point touched_;
    curl_off_t moved_ = 0;
    char message_[CURL_ERROR_SIZE] = {};
};

// ------------------------------------------------------------------------------------------ Connection

// The address of a server without a trailing slash; throws std::invalid_argument if it is invalid.
inline std::string server_url(std::string text) {
    const auto refuse = [&](const char* why) { throw std::invalid_argument("\"" + text + "\" is not the URL of a server: " + why); };
    if (text.rfind("http://", 0) != 0 && text.rfind("https://", 0) != 0) refuse("it begins with http:// or https://");
    const std::unique_ptr<CURLU, decltype(&curl_url_cleanup)> url(curl_url(), &curl_url_cleanup);
    if (!url) throw std::bad_alloc();
    if (curl_url_set(url.get(), CURLUPART_URL, text.c_str(), 0) != CURLUE_OK) refuse("its host or port is none");
    for (const CURLUPart part : {CURLUPART_QUERY, CURLUPART_FRAGMENT}) {
        char* value = nullptr;
        const CURLUcode code = curl_url_get(url.get(), part, &value, 0);
        curl_free(value);
        if (code == CURLUE_OK) refuse("it has a query or a fragment");
    }
    while (text.back() == '/') text.pop_back();
    return text;
}

inline double random_between(double low, double high) {
    std::random_device device;
    return std::uniform_real_distribution<double>(low, high)(device);
}

// A unique key: a random UUID.
inline std::string random_key() {
    std::random_device device;
    static const char hex[] = "0123456789abcdef";
    std::string key = "xxxxxxxx-xxxx-4xxx-yxxx-xxxxxxxxxxxx";
    for (char& c : key) {
        if (c == 'x') c = hex[device() & 15];
        if (c == 'y') c = hex[8 + (device() & 3)];
    }
    return key;
}

// Requests to one server, with retries.
class Connection {
public:
    Connection(const std::string& url, ClientOptions options) : options_(std::move(options)) {
        if (options_.attempts < 1) throw std::invalid_argument("there is one attempt at least");
        header_line(options_.token);
        for (const auto& line : options_.headers) header_line(line);
        initialise_curl();
        url_ = server_url(url);
    }

    // Returns a successful response.
    Answer request(const Call& call) {
        for (int failures = 1;; ++failures) {
            std::chrono::milliseconds pause{0};
            try {
                return once(call, {});
            } catch (const ApiError& error) {
                if (failures > 1 && error.status == call.accepted_again) return {};
                pause = pause_after(failures, 0);
            } catch (const Error&) {
                pause = pause_after(failures, 0);
            }
            call.stop.sleep(pause);
        }
    }

    Json json(const Call& call) { return parse(request(call).body); }

    // Passes the chunks of a response to `sink`, without retries. Returns when the response is complete or the sink
    // stops it.
    void stream(const Call& call, const Sink& sink) { once(call, sink); }

    // Within an exception handler: returns the delay before a retry. Rethrows if a retry is useless or no attempts are
    // left.
    std::chrono::milliseconds pause_after(int failures, double at_least) const {
        bool again = false;
        std::optional<double> asked;
        try {
            throw;
        } catch (const ConnectionLost& error) {
            again = !error.permanent;
        } catch (const ApiError& error) {
            again = error.status == 429 || (error.status >= 502 && error.status <= 504);
            asked = error.retry_after;
        } catch (...) {
        }
        // A server that has responded before may be restarting; another one may not exist.
        const int attempts = answered_ ? options_.attempts : (std::min)(options_.attempts, 3);
        if (!again || failures >= attempts || asked.value_or(0) > 60) throw;
        const double doubled = (std::min)((std::max)(at_least, 0.25) * std::pow(2.0, failures - 1), 30.0);
        // Random jitter, so that clients do not all reconnect at once.
        const double seconds = asked ? *asked * random_between(1.0, 1.1) : doubled * random_between(1.0, 1.5);
        return std::chrono::milliseconds(static_cast<long long>(seconds * 1000));
    }

    // The longest wait that may be requested from the server.
    std::chrono::seconds longest_wait() const { return std::chrono::duration_cast<std::chrono::seconds>(options_.timeout / 2); }

private:
    Answer once(const Call& call, const Sink& sink) {
        std::string url = url_ + call.path;
        char separator = '?';
        for (const auto& [name, value] : call.query) {
            url += separator + escaped(name) + "=" + escaped(value);
            separator = '&';
        }
        auto handle = handles_.take();
        Answer answer;
        std::optional<double> retry_after;
        {
            Transfer transfer(*handle, options_, url, call, sink);
            answer = transfer.perform(answered_);
            retry_after = transfer.retry_after();
        }
        handles_.give_back(std::move(handle));
        if (answer.status / 100 != 2) throw ApiError(problem_of(answer), retry_after);
        return answer;
    }

    // The problem in a response; for responses of proxies it is made from the status.
    static Problem problem_of(const Answer& answer) {
        if (answer.media_type.rfind("application/problem+json", 0) == 0) {
            return reading([&] { return read_problem(parse(answer.body)); });
        }
        Problem problem;
        problem.title = "HTTP status";
        problem.status = answer.status;
        problem.detail = answer.body.substr(0, 1000);
        return problem;
    }

    ClientOptions options_;
    std::string url_;
    HandlePool handles_;
    std::atomic<bool> answered_{false};
};

// The headers of a request for a new job.
inline std::vector<std::string> creating(const std::string& key, std::chrono::seconds wait) {
    std::vector<std::string> headers{"Idempotency-Key: " + (key.empty() ? random_key() : header_line(key))};
    if (wait.count() >= 1) headers.push_back("Prefer: wait=" + std::to_string(wait.count()));
    return headers;
}

inline std::string decimal(double value) { return Json(value).dump(); }

inline void add(Query& query, const char* name, const std::string& value) {
    if (!value.empty()) query.emplace_back(name, value);
}

// The query of a stream, for a job with these defaults.
inline Query shown(const WatchOptions& options, const Json& defaults) {
    Query query;
    add(query, "view", options.view);
    add(query, "samples", options.samples);
    if (options.every != 0) add(query, "every", std::to_string(options.every));
    std::string milestones;
    for (const double one : options.milestones) milestones += (milestones.empty() ? "" : ",") + decimal(one);
    add(query, "milestones", milestones);
    add(query, "pace", options.pace);
    if (options.changed) add(query, "changed", "true");
    add(query, "digits", options.digits);
    const bool decimals = options.changed || !options.digits.empty() || options.view == "errors";
    const bool binary = options.encoding.empty() && !decimals && defaults.is_null();
    add(query, "encoding", binary ? "base64" : options.encoding);
    if (options.from != nullptr) add(query, "describe", "none");
    // Knots are needed, whatever the job sets for its streams.
    else if (defaults.contains("describe")) add(query, "describe", "full");
    return query;
}

// Settings of a stream that has only the first and last iteration, which override those of the job. No job has this
// many iterations.
inline Query ends_only() {
    return {{"view", "errors"}, {"every", "1000000000"}, {"milestones", ""},    {"pace", "all"},
            {"changed", "false"}, {"describe", "full"},  {"encoding", "json"}, {"digits", "full"}};
}

// The events of a job across connections: the stream is reopened after the last iteration received, and returns each
// iteration once and in order.
class Stream {
public:
    using OnIteration = std::function<bool(const Iteration&)>;

    // `first` is sent until the id of the job is known; then its events are requested with `query`, unless it is
    // ephemeral.
    Stream(std::shared_ptr<Connection> connection, Call first, Query query, const WatchOptions& options)
        : connection_(std::move(connection)), call_(std::move(first)), query_(std::move(query)), options_(options), reader_(options.from) {
        call_.accept = "text/event-stream";
        call_.stop = options.stop;
        seen_ = options.after;
        if (seen_) last_event_id_ = std::to_string(*seen_);
    }

    void set_ephemeral() { resumable_ = false; }

    // Called with the `job` event of each connection.
    std::function<void(const Json&)> on_job;

    // The end of the job; nullopt if `on_iteration` returned false before that.
    std::optional<End> run(const OnIteration& on_iteration) {
        for (;;) {
            std::chrono::milliseconds pause{0};
            try {
                connect(on_iteration);
                if (!done_) throw ConnectionLost("the stream ended before the job");
            } catch (const Error&) {
                if (!id_.empty() && !resumable_) throw;
                // The delay requested by servers applies to streams that have started.
                pause = connection_->pause_after(++failures_, id_.empty() ? 0 : parser_.retry());
            }
            // Exceptions of the caller's function are passed on, even if they have the type of a stream error.
            if (thrown_) std::rethrow_exception(thrown_);
            if (done_) return end_;
            call_.stop.sleep(pause);
        }
    }

private:
    void connect(const OnIteration& on_iteration) {
        Call call = call_;
        if (!id_.empty()) {
            call = Call();
            call.path = "/v1/jobs/" + escaped(id_) + "/events";
            call.query = query_;
            call.accept = call_.accept;
            call.stop = call_.stop;
        }
        if (!last_event_id_.empty()) call.headers.push_back("Last-Event-ID: " + last_event_id_);
        parser_.reset();
        connection_->stream(call, [&](const char* data, std::size_t size) {
            return parser_.feed(data, size, [&](const Event& event) { return take(event, on_iteration); });
        });
    }

    bool take(const Event& event, const OnIteration& on_iteration) {
        call_.stop.throw_if_stopped();
        // Later versions may send events of other kinds.
        if (event.name != "job" && event.name != "iteration" && event.name != "end") return true;
        const Json data = parse(event.data);
        if (event.name == "job") return take_job(data);
        if (event.name == "iteration") return take_iteration(event, data, on_iteration);
        end_ = read_end(data, id_);
        done_ = true;
        return false;
    }

    bool take_job(const Json& data) {
        reading([&] {
            id_ = data.at("id").get<std::string>();
            if (text(data, "resumed") == "restarted") seen_.reset();
            reader_.job(data);
        });
        return call_back([&] {
            if (on_job) on_job(data);
            if (options_.on_job) options_.on_job(data);
            return true;
        });
    }

    bool take_iteration(const Event& event, const Json& data, const OnIteration& on_iteration) {
        const Iteration& iteration = *reading([&] { return &reader_.iteration(data); });
        if (seen_ && iteration.number <= *seen_) return true;
        seen_ = iteration.number;
        last_event_id_ = header_line(event.id);
        failures_ = 0;
        return call_back([&] { return on_iteration(iteration); });
    }

    template <class Function>
    bool call_back(const Function& function) {
        try {
            done_ = !function();
        } catch (...) {
            thrown_ = std::current_exception();
        }
        return !done_ && !thrown_;
    }

    std::shared_ptr<Connection> connection_;
    Call call_;
    Query query_;
    const WatchOptions& options_;
    IterationReader reader_;
    EventParser parser_;
    std::string id_;
    std::string last_event_id_;
    std::optional<std::uint64_t> seen_;
    std::optional<End> end_;
    std::exception_ptr thrown_;
    bool resumable_ = true;
    bool done_ = false;
    int failures_ = 0;
};

// Calls a function that returns void, or false to stop.
template <class Value, class Function>
std::function<bool(const Value&)> going_on(Function& function) {
    using Returned = std::invoke_result_t<Function&, const Value&>;
    static_assert(std::is_void_v<Returned> || std::is_convertible_v<Returned, bool>, "the function returns bool or nothing");
    return [&function](const Value& value) -> bool {
        if constexpr (std::is_void_v<Returned>) {
            function(value);
            return true;
        } else {
            return function(value);
        }
    };
}

template <class Function>
Stream::OnIteration on_iteration(Function& function) {
    return going_on<Iteration>(function);
}

// Sends the items of a batch in requests of bounded size. After a broken connection, items without a result are sent
// again.
class Batch {
public:
    using OnItem = std::function<bool(const BatchItem&)>;

    Batch(std::shared_ptr<Connection> connection, const BatchOptions& options, OnItem on_item)
        : connection_(std::move(connection)), options_(options), on_item_(std::move(on_item)) {
        if (!options.defaults.is_null()) defaults_ = "\"defaults\":" + encoded(options.defaults) + ",";
    }

    // Adds an item and sends a full group. Returns false to stop.
    bool add(const Json& item) {
        auto text = encoded(item);
        const bool is_full = bytes_ + text.size() > 256 * 1024 || part_.size() >= 5000 || Clock::now() - begun_ > std::chrono::milliseconds(500);
        if (!part_.empty() && is_full && !send()) return false;
        if (part_.empty()) begun_ = Clock::now();
        bytes_ += text.size();
        part_.push_back(std::move(text));
        return true;
    }

    // Sends the remaining items. Returns false to stop.
    bool send() {
        failures_ = 0;
        while (!part_.empty()) {
            std::chrono::milliseconds pause{0};
            first_ = totals_.items;
            ended_ = false;
            try {
                connect();
                if (!ended_ && !done_ && !thrown_) throw ConnectionLost("the answer to the batch has no end");
            } catch (const Error&) {
                // Exceptions of the caller's function are passed on, even if they have the type of a batch error.
                if (!thrown_) pause = connection_->pause_after(++failures_, 0);
            }
            if (thrown_) std::rethrow_exception(thrown_);
            if (done_) return false;
            part_.erase(part_.begin(), part_.begin() + static_cast<std::ptrdiff_t>(totals_.items - first_));
            if (ended_) part_.clear();
            options_.stop.sleep(pause);
        }
        bytes_ = 0;
        return true;
    }

    const BatchTotals& totals() const { return totals_; }

private:
    using Clock = StopToken::Clock;

    void connect() {
        Call call;
        call.method = "POST";
        call.path = "/v1/batch";
        call.query = {{"encoding", "base64"}};
        call.accept = "application/x-ndjson";
        call.content_type = "application/json";
        call.body = "{" + defaults_ + "\"items\":[";
        for (std::size_t i = 0; i < part_.size(); ++i) call.body += (i == 0 ? "" : ",") + part_[i];
        call.body += "]}";
        call.stop = options_.stop;
        line_.clear();
        connection_->stream(call, [&](const char* data, std::size_t size) { return feed(data, size); });
    }

    bool feed(const char* data, std::size_t size) {
        while (const auto* end = static_cast<const char*>(size == 0 ? nullptr : std::memchr(data, '\n', size))) {
            const auto length = static_cast<std::size_t>(end - data);
            line_.append(data, length);
            data += length + 1;
            size -= length + 1;
            const auto line = std::exchange(line_, {});
            if (!line.empty() && !take(parse(line))) return false;
        }
        line_.append(data, size);
        return true;
    }

    bool take(const Json& value) {
        options_.stop.throw_if_stopped();
        if (value.contains("totals")) ended_ = true;
        if (ended_) return true;
        if (!value.contains("index")) throw ApiError(reading([&] { return read_problem(value.at("problem")); }));
        const auto item = read_batch_item(value, first_);
        ++totals_.items;
        ++(item.state == "converged" ? totals_.converged : totals_.failed);
        failures_ = 0;
        try {
            done_ = !on_item_(item);
        } catch (...) {
            thrown_ = std::current_exception();
        }
        return !done_ && !thrown_;
    }

    std::shared_ptr<Connection> connection_;
    const BatchOptions& options_;
    OnItem on_item_;
    std::string defaults_;
    std::vector<std::string> part_;
    std::size_t bytes_ = 0;
    Clock::time_point begun_;
    std::uint64_t first_ = 0;
    std::string line_;
    BatchTotals totals_;
    std::exception_ptr thrown_;
    bool ended_ = false;
    bool done_ = false;
    int failures_ = 0;
};

}  // namespace detail

// -------------------------------------------------------------------------------------------------- Job

// A job and its operations. `client.job(id)` returns the job with this id.
class Job {
public:
    const std::string& id() const { return status_.id; }

    // The last state received from the server; `refresh` updates it.
    const JobStatus& status() const { return status_; }

    const JobStatus& refresh(const StopToken& stop = {}) {
        status_ = detail::read_status(connection_->json(get("", {}, stop)));
        return status_;
    }

    // Waits until the job has ended. The job continues if the token cancels this: `stop.after(10s)` is a timeout.
    const JobStatus& wait(const StopToken& stop = {}) {
        if (status_.ended()) return status_;
        WatchOptions options;
        options.stop = stop;
        detail::Stream(connection_, get("/events", detail::ends_only(), stop), detail::ends_only(), options).run([](const Iteration&) { return true; });
        return refresh(stop);
    }

    // Waits for the last iteration. A cancelled job has a result if it computed an iteration; otherwise throws
    // `JobFailed`.
    Result result(const StopToken& stop = {}) {
        wait(stop);
        if (status_.state == "failed" || !status_.iteration) throw JobFailed(status_.id, status_.state, status_.problem);
        return detail::read_result(connection_->json(get("/result", {{"encoding", "base64"}}, stop)));
    }

    // Calls `function(const Iteration&)` for each iteration as it is computed, until the job ends. Each one from 0 (or
    // after `options.after`) arrives once and in order, despite broken connections and restarts of the server, unless
    // options skip some. Nothing is read ahead: a slow function holds back the server. The next iteration overwrites
    // the object: copy what you need. If the function returns false, the stream ends and nullopt is returned, otherwise
    // the end of the job. The job itself continues in any case.
    template <class Function>
    std::optional<End> watch(Function&& function, const WatchOptions& options = {}) {
        const auto query = detail::shown(options, defaults());
        detail::Stream stream(connection_, get("/events", query, options.stop), query, options);
        auto end = stream.run(detail::on_iteration(function));
        if (end) refresh(options.stop);
        return end;
    }

    // One iteration with its geometry, by default the last; waits for one that is not computed yet.
    Iteration iteration(std::optional<std::uint64_t> number = {}, const StopToken& stop = {}) {
        detail::IterationReader reader;
        WatchOptions options;
        options.stop = stop;
        // Only the first event of the stream has knots.
        detail::Stream ends(connection_, get("/events", detail::ends_only(), stop), detail::ends_only(), options);
        bool described = false;
        ends.on_job = [&](const Json& job) {
            detail::reading([&] { reader.job(job); });
            described = true;
        };
        ends.run([](const Iteration&) { return false; });
        if (!described) throw JobFailed(status_.id, refresh(stop).state, status_.problem);
        auto call = get("/iterations/" + (number ? std::to_string(*number) : "last"), {{"encoding", "base64"}}, stop);
        const auto wait = (std::min)(connection_->longest_wait(), std::chrono::seconds(10));
        call.headers.push_back("Prefer: wait=" + std::to_string(wait.count()));
        const Json level = connection_->json(call);
        return detail::reading([&] { return reader.iteration(level); });
    }

    // Cancels the job. Throws `ApiError` of type "/problems/already-ended" if it has ended otherwise.
    const JobStatus& cancel(const StopToken& stop = {}) {
        auto call = get("/cancel", {}, stop);
        call.method = "POST";
        status_ = detail::read_status(connection_->json(call));
        return status_;
    }

    // Deletes the job.
    void remove(const StopToken& stop = {}) {
        auto call = get("", {}, stop);
        call.method = "DELETE";
        call.accepted_again = 404;
        connection_->request(call);
    }

    // Creates a job that starts from the control points of this one; settings that the edit does not name are kept.
    Job edit(const Json& edit, const CreateOptions& options = {}) const {
        return create(connection_, path() + "/edits", edit, options);
    }

    // The same, streaming iterations in the response. With "ephemeral": true nothing is stored, as for one position of
    // a dragged point; throws `ConnectionLost` if the connection breaks.
    template <class Function>
    std::optional<End> edit_watch(const Json& edit, Function&& function, const WatchOptions& options = {}) const {
        const Json& own = edit.contains("stream") ? edit.at("stream") : defaults();
        return watch_new(connection_, path() + "/edits/stream", edit, own, detail::on_iteration(function), options);
    }

    // The distances of the data from the nearest points of an iteration (by default the last), with `list` also of each
    // point.
    Deviation deviation(bool list = false, std::optional<std::uint64_t> number = {}, const StopToken& stop = {}) const {
        const Query query{{"iteration", number ? std::to_string(*number) : "last"}, {"list", list ? "true" : "false"}};
        const Json value = connection_->json(get("/deviation", query, stop));
        return detail::reading([&] {
            Deviation deviation;
            deviation.iteration = value.at("iteration").get<std::uint64_t>();
            deviation.max = detail::number(value.at("max"));
            deviation.rms = detail::number(value.at("rms"));
            deviation.at = detail::read_index(value.at("at"));
            for (const auto& [name, distance] : value.at("percentiles").items()) deviation.percentiles[std::stoi(name)] = detail::number(distance);
            if (list) deviation.distances = detail::numbers(value.at("distances"));
            if (list && value.contains("between")) deviation.between = detail::numbers(value.at("between"));
            return deviation;
        });
    }

    // The request that created the job. Sent again, it creates the same job.
    Json input(const StopToken& stop = {}) const { return connection_->json(get("/input", {}, stop)); }

    // Exports the result, or an iteration, as a file: "step" or another format of docs/reference/files.md.
    File file(const std::string& format, const FileOptions& options = {}) const {
        const auto part = options.iteration ? "/iterations/" + std::to_string(*options.iteration) : std::string("/result");
        auto call = get(part + "/" + detail::escaped(format), {}, options.stop);
        detail::add(call.query, "samples", options.samples);
        detail::add(call.query, "units", options.units);
        detail::add(call.query, "dots", options.dots);
        call.accept = "*/*";
        auto answer = connection_->request(call);
        return {std::move(answer.file_name), std::move(answer.media_type), std::move(answer.body)};
    }

    // Returns a ticket that opens the stream of this job for one minute without a token, as in a browser: the query
    // parameter `ticket` of its events. Throws `ApiError` with status 409 if the server requires no tokens.
    std::string ticket(const StopToken& stop = {}) const {
        auto call = get("/tickets", {}, stop);
        call.method = "POST";
        const Json answer = connection_->json(call);
        return detail::reading([&] { return answer.at("ticket").get<std::string>(); });
    }

private:
    friend class Client;

    Job(std::shared_ptr<detail::Connection> connection, JobStatus status) : connection_(std::move(connection)), status_(std::move(status)) {}

    std::string path() const { return "/v1/jobs/" + detail::escaped(status_.id); }

    const Json& defaults() const {
        static const Json none;
        const auto found = status_.json.find("stream");
        return found == status_.json.end() ? none : *found;
    }

    detail::Call get(const std::string& part, Query query, const StopToken& stop) const {
        detail::Call call;
        call.path = path() + part;
        call.query = std::move(query);
        call.stop = stop;
        return call;
    }

    static detail::Call post(const std::string& path, const Json& body) {
        detail::Call call;
        call.method = "POST";
        call.path = path;
        call.content_type = "application/json";
        call.body = detail::encoded(body);
        return call;
    }

    static Job create(const std::shared_ptr<detail::Connection>& connection, const std::string& path, const Json& body, const CreateOptions& options) {
        auto call = post(path, body);
        call.headers = detail::creating(options.idempotency_key, (std::min)(options.wait, connection->longest_wait()));
        call.stop = options.stop;
        return Job(connection, detail::read_status(connection->json(call)));
    }

    static std::optional<End> watch_new(const std::shared_ptr<detail::Connection>& connection, const std::string& path, const Json& body,
                                        const Json& defaults, const detail::Stream::OnIteration& on_iteration, const WatchOptions& options) {
        auto call = post(path, body);
        const auto query = detail::shown(options, defaults);
        call.query = query;
        detail::add(call.query, "on_disconnect", options.on_disconnect);
        const bool ephemeral = body.is_object() && body.value("ephemeral", Json()) == true;
        // Nothing is stored, so there is nothing to find by a key or to resume.
        if (!ephemeral) call.headers = detail::creating(options.idempotency_key, std::chrono::seconds(0));
        detail::Stream stream(connection, std::move(call), query, options);
        if (ephemeral) stream.set_ephemeral();
        return stream.run(on_iteration);
    }

    std::shared_ptr<detail::Connection> connection_;
    JobStatus status_;
};

// ----------------------------------------------------------------------------------------------- Client

// A server. Copies share their connections.
class Client {
public:
    explicit Client(const std::string& url = "http://127.0.0.1:8080", ClientOptions options = {})
        : connection_(std::make_shared<detail::Connection>(url, std::move(options))) {}

    // Creates a job, which starts immediately. Requests are the JSON of docs/reference/job.md.
    Job create(const Json& request, const CreateOptions& options = {}) const { return Job::create(connection_, "/v1/jobs", request, options); }

    // Creates a job and waits for its result. A fit that has not reached its tolerance also has a result, whose `state`
    // is not "converged".
    Result fit(const Json& request, CreateOptions options = {}) const {
        if (options.wait.count() == 0) options.wait = std::chrono::seconds(10);
        return create(request, options).result(options.stop);
    }

    // Fits without creating a job; nothing is stored. Throws `ApiError` with status 422 if the tolerance is not
    // reached. The server must respond within `timeout`.
    Result fit_once(const Json& request, const StopToken& stop = {}) const {
        auto call = Job::post("/v1/fit", request);
        call.query = {{"encoding", "base64"}};
        call.stop = stop;
        return detail::read_result(connection_->json(call));
    }

    // Fits many items, which is much faster than one request each. `items` is a range of jobs as JSON, which are read
    // and sent in groups, and not stored. The function is called with a `BatchItem` for each, in order; it may return
    // false to end the batch. A failed item has a `problem` and does not end the batch.
    template <class Items, class Function>
    BatchTotals batch(const Items& items, Function&& function, const BatchOptions& options = {}) const {
        detail::Batch batch(connection_, options, detail::going_on<BatchItem>(function));
        for (const Json& item : items) {
            if (!batch.add(item)) return batch.totals();
        }
        batch.send();
        return batch.totals();
    }

    // Creates a job and streams its iterations in the response; see `Job::watch`. `job(end->id)` is the job.
    template <class Function>
    std::optional<End> watch(const Json& request, Function&& function, const WatchOptions& options = {}) const {
        static const Json none;
        const Json& own = request.contains("stream") ? request.at("stream") : none;
        return Job::watch_new(connection_, "/v1/jobs/stream", request, own, detail::on_iteration(function), options);
    }

    Job job(const std::string& id, const StopToken& stop = {}) const {
        return Job(connection_, detail::read_status(get("/v1/jobs/" + detail::escaped(id), {}, stop)));
    }

    // Jobs, newest first.
    std::vector<Job> jobs(const ListOptions& options = {}) const {
        std::vector<Job> jobs;
        std::string cursor;
        while (jobs.size() < options.limit) {
            Query query{{"limit", std::to_string((std::min)(options.limit - jobs.size(), std::size_t{1000}))}};
            detail::add(query, "state", options.state);
            detail::add(query, "cursor", cursor);
            const Json page = get("/v1/jobs", query, options.stop);
            const auto next = detail::reading([&] {
                for (const auto& job : page.at("jobs")) jobs.push_back(Job(connection_, detail::read_status(job)));
                return detail::text(page, "next");
            });
            const auto begin = next.find("cursor=");
            if (begin == std::string::npos) break;
            cursor = next.substr(begin + 7, next.find('&', begin) - begin - 7);
        }
        return jobs;
    }

    // Reads the points of a file (CSV, tables, airfoils, point clouds) as the "curve" or "surface" of a job.
    // `size`, such as "40x60", makes them rows and columns of a surface.
    Json read_points(const std::string& content, const std::string& size = "", const StopToken& stop = {}) const {
        detail::Call call;
        call.method = "POST";
        call.path = "/v1/points";
        detail::add(call.query, "surface.size", size);
        call.content_type = "text/csv";
        call.body = content;
        call.stop = stop;
        return connection_->json(call);
    }

    // The response to GET of another path, such as "/v1/capabilities" or "/v1/rates".
    Json get(const std::string& path, const Query& query = {}, const StopToken& stop = {}) const {
        detail::Call call;
        call.path = path;
        call.query = query;
        call.stop = stop;
        return connection_->json(call);
    }

private:
    std::shared_ptr<detail::Connection> connection_;
};

}  // namespace piad

#endif  // PIAD_PIAD_HPP
