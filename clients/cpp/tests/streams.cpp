// Streams: skipped iterations, broken connections, restarts, slow readers and stop tokens.

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <future>
#include <string>
#include <thread>

#include "check.hpp"
#include "jobs.hpp"
#include "piad.hpp"
#include "scripted.hpp"
#include "server.hpp"

using piad::Client;
using piad::Iteration;
using piad::Json;
using testing::ScriptedServer;
using testing::streams;
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

namespace {

Client client() { return Client(testing::server().url()); }

void nothing(const Iteration&) {}

std::vector<std::uint64_t> numbers_of(const Json& job, const piad::WatchOptions& options = {}) {
    std::vector<std::uint64_t> numbers;
    const auto end = client().watch(job, [&](const Iteration& iteration) { numbers.push_back(iteration.number); }, options);
    CHECK(end.has_value());
    CHECK_EQUAL(end->iterations, numbers.back());
    return numbers;
}

bool is_complete(const std::vector<std::uint64_t>& numbers, std::uint64_t last) {
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        if (numbers[i] != i) return false;
    }
    return numbers.size() == last + 1;
}

std::string event(const std::string& name, const std::string& id, const std::string& data) {
    return "event: " + name + "\n" + (id.empty() ? "" : "id: " + id + "\n") + "data: " + data + "\n\n";
}

std::string described(const std::string& more = "") {
    return event("job", "", R"({"id":"j","kind":"curve","basis":"bspline","degree":1,"closed":false,"rational":null,"control_points":1,"weights":null,"knots":[0,0,1],"parameters":[0])" + more + "}");
}

std::string iteration(int number, const std::string& id = "") {
    const auto k = std::to_string(number);
    return event("iteration", id.empty() ? k : id, R"({"iteration":)" + k + R"(,"error":{"max":1,"rms":1,"sum":1,"at":0},"moved":1,"control_points":[[)" + k + "]]}");
}

const std::string end = event("end", "end", R"({"state":"converged","reason":null,"detail":null,"iterations":3,"error":null,"elapsed":0.5,"links":null})");

// Cancels `call` from another thread after this time; checks that it throws `Stopped` soon and
// returns the delay.
template <class Call>
double stopped_after(milliseconds time, const Call& call) {
    const piad::StopSource source;
    auto stopping = std::async(std::launch::async, [&] {
        std::this_thread::sleep_for(time);
        const auto begin = Clock::now();
        source.stop();
        return begin;
    });
    THROWN(piad::Stopped, call(source.token()));
    const auto end = Clock::now();
    return std::chrono::duration<double>(end - stopping.get()).count();
}

}  // namespace

TEST(every_iteration_once_and_in_order) {
    CHECK(is_complete(numbers_of(testing::iterations(300)), 300));
    auto job = client().create(testing::iterations(20));
    std::vector<std::uint64_t> numbers;
    piad::WatchOptions options;
    options.after = 15;
    const auto end = job.watch([&](const Iteration& iteration) { numbers.push_back(iteration.number); }, options);
    CHECK(numbers == std::vector<std::uint64_t>({16, 17, 18, 19, 20}));
    CHECK_EQUAL(end->state, "exhausted");
    CHECK_EQUAL(job.status().state, "exhausted");
}

TEST(what_streams_leave_out) {
    piad::WatchOptions options;
    options.every = 7;
    CHECK(numbers_of(testing::iterations(20), options) == std::vector<std::uint64_t>({0, 7, 14, 20}));
    options = {};
    options.milestones = {1e-1, 1e-2, 1e-3};
    std::vector<double> reached;
    client().watch(testing::curve(), [&](const Iteration& one) { reached.push_back(one.milestone.value_or(0)); }, options);
    CHECK(reached.size() > 1 && reached.back() == 0 && std::count(reached.begin(), reached.end(), 1e-3) == 1);
    options = {};
    options.view = "errors";
    client().watch(testing::curve(), [](const Iteration& one) { CHECK(one.control_points.empty() && one.error.max >= 0); }, options);
    options.view = "samples";
    options.samples = "7x5";
    client().watch(testing::surface(), [](const Iteration& one) {
        CHECK(one.samples.shape == std::vector<std::size_t>({7, 5, 3}));
        CHECK_EQUAL(one.samples.points.size(), 105u);
        CHECK(one.samples.parameters.size() == 2 && one.samples.parameters[0].size() == 7 && one.samples.parameters[1].size() == 5);
    }, options);
}

TEST(differences_make_iterations) {
    for (auto job : {testing::curve(300), testing::curve(60), testing::surface()}) {
        if (job.contains("curve") && job["curve"]["points"].size() == 60) job["curve"]["weights"] = std::vector<double>(60, 2.0);
        for (const char* view : {"control_points", "samples"}) {
            std::vector<Iteration> exact;
            std::vector<Iteration> near;
            piad::WatchOptions options;
            options.view = view;
            options.encoding = "base64";
            client().watch(job, [&](const Iteration& one) { exact.push_back(one); }, options);
            options.encoding = "delta";
            client().watch(job, [&](const Iteration& one) { near.push_back(one); }, options);
            CHECK(exact.size() > 2);
            CHECK_EQUAL(exact.size(), near.size());
            for (std::size_t k = 0; k < exact.size(); ++k) {
                const double bound = exact[k].error.max / 64 + 1e-13;
                const auto are_near = [&](const std::vector<double>& a, const std::vector<double>& b) {
                    return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), [&](double x, double y) { return std::abs(x - y) <= bound; });
                };
                CHECK(are_near(exact[k].control_points, near[k].control_points));
                CHECK(are_near(exact[k].weights, near[k].weights));
                CHECK(are_near(exact[k].samples.points, near[k].samples.points));
            }
            CHECK(exact.back().control_points == near.back().control_points);
            CHECK(exact.back().weights == near.back().weights);
            CHECK(exact.back().samples.points == near.back().samples.points);
        }
    }
}

TEST(changes_make_complete_iterations) {
    for (auto job : {testing::curve(60), testing::surface()}) {
        const bool surface = job.contains("surface");
        job["method"] = {{"kind", "local"}, {"indices", surface ? Json{{2, 2}, {3, 2}} : Json{5, 6}}};
        if (!surface) job["curve"]["weights"] = std::vector<double>(60, 2.0);
        std::vector<Iteration> complete;
        std::vector<Iteration> changed;
        client().watch(job, [&](const Iteration& one) { complete.push_back(one); });
        piad::WatchOptions options;
        options.changed = true;
        client().watch(job, [&](const Iteration& one) { changed.push_back(one); }, options);
        CHECK(complete.size() > 2);
        CHECK_EQUAL(complete.size(), changed.size());
        for (std::size_t i = 0; i < complete.size(); ++i) {
            CHECK(complete[i].control_points == changed[i].control_points);
            CHECK(complete[i].weights == changed[i].weights);
        }
    }
}

TEST(fits_that_choose_their_knots) {
    auto job = testing::curve(60);
    job["method"] = {{"kind", "least_squares"}, {"control_points", "auto"}};
    job["stop"] = {{"tolerance", 0.01}};
    std::vector<std::size_t> counts;
    Iteration last;
    auto made = client().create(job);
    made.watch([&](const Iteration& one) {
        CHECK_EQUAL(one.knots().size(), one.shape[0] + 4);
        counts.push_back(one.shape[0]);
        last = one;
    });
    CHECK(*std::max_element(counts.begin(), counts.end()) > *std::min_element(counts.begin(), counts.end()));
    CHECK(last.knots() == made.result().knots());
    CHECK(last.knots() == made.iteration().knots());
}

TEST(streams_that_the_job_has_set_up) {
    auto job = testing::iterations(10);
    job["stream"] = {{"every", 5}, {"encoding", "base64_f32"}, {"describe", "none"}};
    std::vector<std::uint64_t> numbers;
    auto made = client().create(job);
    made.watch([&](const Iteration& one) {
        numbers.push_back(one.number);
        CHECK_EQUAL(one.control_points.size(), one.shape[0] * 3);
        CHECK_EQUAL(one.knots().size(), one.shape[0] + 4);
    });
    CHECK(numbers == std::vector<std::uint64_t>({0, 5, 10}));
    CHECK(made.result().state == "exhausted" && made.iteration().knots() == made.result().knots());
}

TEST(the_function_ends_the_stream) {
    std::uint64_t last = 0;
    auto job = client().create(testing::endless());
    const auto ended = job.watch([&](const Iteration& one) {
        last = one.number;
        return one.number < 3;
    });
    CHECK(!ended);
    CHECK_EQUAL(last, 3u);
    CHECK_EQUAL(job.refresh().state, "running");
    job.cancel();
    piad::WatchOptions options;
    options.on_disconnect = "cancel";
    std::string id;
    options.on_job = [&](const Json& data) { id = data.at("id"); };
    client().watch(testing::endless(), [](const Iteration&) { return false; }, options);
    CHECK_EQUAL(client().job(id).wait(piad::StopToken().after(std::chrono::seconds(10))).state, "cancelled");
}

TEST(exceptions_of_the_function_are_thrown_on) {
    int calls = 0;
    const auto lost = [&](const Iteration&) {
        ++calls;
        throw piad::ConnectionLost("mine");
    };
    CHECK_EQUAL(std::string(THROWN(piad::ConnectionLost, client().watch(testing::curve(), lost)).what()), "mine");
    CHECK_EQUAL(calls, 1);
    THROWN(int, client().watch(testing::curve(), [](const Iteration&) { throw 7; }));
    // Other requests work meanwhile.
    std::string state;
    client().watch(testing::curve(), [&](const Iteration&) { state = client().fit(testing::curve(4)).state; });
    CHECK_EQUAL(state, "converged");
}

TEST(a_broken_stream_goes_on_after_the_last_iteration) {
    // The second connection sends an iteration again; the first and third break within an event.
    const ScriptedServer server({streams("retry: 10\n\n" + described() + iteration(0) + iteration(1).substr(0, 30)),
                                 streams(described() + iteration(0) + iteration(1, "1@2") + iteration(2, "2@2")),
                                 testing::says("503 Service Unavailable", ""), streams(described() + ": quiet\n\n" + iteration(3) + end)});
    std::vector<double> seen;
    const auto ended = Client(server.url()).watch(testing::curve(), [&](const Iteration& one) { seen.push_back(one.control_points[0]); });
    CHECK(seen == std::vector<double>({0, 1, 2, 3}));
    CHECK_EQUAL(ended->id, "j");
    CHECK_EQUAL(ended->elapsed.value_or(0), 0.5);
    const auto requests = server.requests();
    CHECK_EQUAL(requests.size(), 4u);
    CHECK_EQUAL(requests[0].substr(0, 32), "POST /v1/jobs/stream?encoding=ba");
    CHECK_EQUAL(requests[1].substr(0, 24), "GET /v1/jobs/j/events?en");
    CHECK(requests[1].find("Last-Event-ID: 0\r\n") != std::string::npos);
    CHECK(requests[2].find("Last-Event-ID: 2@2\r\n") != std::string::npos);
}

TEST(all_iterations_come_again_from_another_version) {
    const ScriptedServer server({streams("retry: 10\n\n" + described() + iteration(0) + iteration(1)),
                                 streams(described(R"(,"resumed":"restarted")") + iteration(0, "0@2") + iteration(1, "1@2") + end)});
    std::vector<std::uint64_t> numbers;
    int restarts = 0;
    piad::WatchOptions options;
    options.on_job = [&](const Json& job) { restarts += job.value("resumed", "") == "restarted"; };
    Client(server.url()).watch(testing::curve(), [&](const Iteration& one) { numbers.push_back(one.number); }, options);
    CHECK(numbers == std::vector<std::uint64_t>({0, 1, 0, 1}));
    CHECK_EQUAL(restarts, 1);
}

TEST(a_stream_that_does_not_get_on_is_given_up) {
    piad::ClientOptions options;
    options.attempts = 4;
    const ScriptedServer server({streams("retry: 10\n\n" + described() + iteration(0)), streams(described())});
    THROWN(piad::ConnectionLost, Client(server.url(), options).watch(testing::curve(), nothing));
    CHECK_EQUAL(server.requests().size(), 4u);
}

TEST(a_slow_function_holds_the_server_back) {
    std::atomic<std::size_t> sent{0};
    std::string first = described() + iteration(0);
    const std::string comment = ": " + std::string(65533, '-') + "\n";
    const ScriptedServer server({[&](int peer) {
        streams(first)(peer);
        while (testing::send_all(peer, comment) && sent < (1u << 30)) sent += comment.size();
    }});
    std::size_t during = 0;
    Client(server.url()).watch(testing::curve(), [&](const Iteration&) {
        std::this_thread::sleep_for(milliseconds(500));
        during = sent;
        return false;
    });
    // The size of the kernel's buffers at both ends; unbounded reading would take hundreds of
    // megabytes.
    CHECK(during < (32u << 20));
}

TEST(stopped_in_the_middle_of_a_stream) {
    piad::WatchOptions options;
    std::uint64_t count = 0;
    const auto busy = stopped_after(milliseconds(300), [&](const piad::StopToken& token) {
        options.stop = token;
        options.on_disconnect = "cancel";
        client().watch(testing::endless(), [&](const Iteration&) { ++count; }, options);
    });
    CHECK(count > 0);
    CHECK(busy < 0.5);
    // While nothing arrives.
    const ScriptedServer silent({[](int peer) {
        streams(described() + iteration(0))(peer);
        std::array<char, 1> byte{};
        static_cast<void>(::read(peer, byte.data(), 1));
    }});
    const auto quiet = stopped_after(milliseconds(300), [&](const piad::StopToken& token) {
        options.stop = token;
        Client(silent.url()).watch(testing::curve(), nothing, options);
    });
    CHECK(quiet < 0.5);
}

TEST(stopped_while_waiting) {
    auto job = client().create(testing::endless());
    CHECK(stopped_after(milliseconds(200), [&](const piad::StopToken& token) { job.wait(token); }) < 0.5);
    CHECK(stopped_after(milliseconds(200), [&](const piad::StopToken& token) { job.iteration(1000000000, token); }) < 0.5);
    piad::CreateOptions options;
    options.wait = std::chrono::seconds(20);
    CHECK(stopped_after(milliseconds(200), [&](const piad::StopToken& token) {
        options.stop = token;
        client().create(testing::endless(), options);
    }) < 0.5);
    // The delay before a retry.
    const ScriptedServer busy({testing::says("503 Service Unavailable", "", "Retry-After: 30\r\n")});
    CHECK(stopped_after(milliseconds(200), [&](const piad::StopToken& token) { Client(busy.url()).job("j", token); }) < 0.5);
    const auto begin = Clock::now();
    THROWN(piad::Stopped, job.wait(piad::StopToken().after(milliseconds(200))));
    CHECK(Clock::now() - begin >= milliseconds(200) && Clock::now() - begin < milliseconds(700));
    THROWN(piad::Stopped, job.wait(piad::StopToken().after(milliseconds(-1))));
    for (auto& one : client().jobs({"running", 10, {}})) one.cancel();
}

TEST(a_server_that_is_killed_and_comes_back) {
    const std::string store = "restart.jobs";
    std::filesystem::remove_all(store);
    testing::Server server("", store);
    const Client client(server.url());
    std::vector<std::uint64_t> numbers;
    std::future<void> restart;
    const auto end = client.watch(testing::iterations(4000, 200), [&](const Iteration& one) {
        numbers.push_back(one.number);
        if (one.number != 5) return;
        // Killed while the stream is read; further iterations may be in transit.
        server.stop(SIGKILL);
        restart = std::async(std::launch::async, [&] {
            std::this_thread::sleep_for(milliseconds(300));
            server.start();
        });
    });
    restart.get();
    CHECK_EQUAL(end->state, "exhausted");
    CHECK(is_complete(numbers, 4000));
    // A server that shuts down ends its streams without an `end` event.
    auto job = client.create(testing::iterations(20000, 200));
    std::vector<std::uint64_t> others;
    job.watch([&](const Iteration& one) {
        others.push_back(one.number);
        if (one.number != 5) return;
        restart = std::async(std::launch::async, [&] {
            server.stop(SIGTERM);
            server.start();
        });
    });
    restart.get();
    CHECK_EQUAL(job.status().state, "exhausted");
    CHECK(is_complete(others, 20000));
}
