// Errors of callers, servers and networks.

#include <chrono>
#include <cmath>
#include <limits>
#include <string>

#include "check.hpp"
#include "jobs.hpp"
#include "piad.hpp"
#include "scripted.hpp"
#include "server.hpp"

using piad::Client;
using piad::Json;
using testing::says;
using testing::ScriptedServer;

namespace {

double seconds_since(std::chrono::steady_clock::time_point begin) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

const std::string job = R"({"id":"j","name":null,"kind":"curve","state":"running","progress":0,"iteration":null,"error":null})";

// The value of a header of a request.
std::string header(const std::string& request, const std::string& name) {
    const auto begin = request.find("\r\n" + name + ": ");
    if (begin == std::string::npos) return "";
    const auto from = begin + name.size() + 4;
    return request.substr(from, request.find("\r\n", from) - from);
}

}  // namespace

TEST(addresses_that_are_none) {
    for (const char* url : {"", "127.0.0.1:8080", "localhost", "ftp://127.0.0.1", "http://", "http://127.0.0.1:99999", "http://127.0.0.1:8080/?a=b"}) {
        const auto error = THROWN(std::invalid_argument, Client{url});
        CHECK(std::string(error.what()).find("is not the URL of a server") != std::string::npos);
    }
    CHECK_EQUAL(Client(testing::server().url() + "/").fit(testing::curve()).state, "converged");
}

TEST(options_that_cannot_be) {
    piad::ClientOptions options;
    options.attempts = 0;
    THROWN(std::invalid_argument, Client("http://127.0.0.1:1", options));
    options.attempts = 1;
    options.token = "two\r\nlines";
    THROWN(std::invalid_argument, Client("http://127.0.0.1:1", options));
    piad::CreateOptions creation;
    creation.idempotency_key = "two\nlines";
    THROWN(std::invalid_argument, Client(testing::server().url()).create(testing::curve(), creation));
}

TEST(numbers_that_json_does_not_have) {
    auto input = testing::curve();
    input["curve"]["points"][3][1] = std::nan("");
    const auto error = THROWN(std::invalid_argument, Client(testing::server().url()).create(input));
    CHECK(std::string(error.what()).find("/curve/points/3/1") != std::string::npos);
    input["curve"]["points"][3][1] = 0;
    input["name"] = "\xff";
    THROWN(std::invalid_argument, Client(testing::server().url()).create(input));
}

TEST(nobody_is_there) {
    const auto begin = std::chrono::steady_clock::now();
    const auto error = THROWN(piad::ConnectionLost, Client("http://127.0.0.1:1").fit(testing::curve()));
    CHECK(!error.permanent);
    // Two delays, of a quarter and half a second plus jitter of up to 50%.
    CHECK(seconds_since(begin) >= 0.7 && seconds_since(begin) < 5);
    THROWN(piad::ConnectionLost, Client("http://127.0.0.1:1").watch(testing::curve(), [](const piad::Iteration&) {}));
}

TEST(requests_that_are_wrong) {
    const Client client(testing::server().url());
    const Json input{{"curve", {{"points", {{0, 0}, {1, 2}, {1, 2}, {4}}}}}};
    for (int i = 0; i < 2; ++i) {
        const auto error = i == 0 ? THROWN(piad::ApiError, client.create(input)) : THROWN(piad::ApiError, client.watch(input, [](const piad::Iteration&) {}));
        CHECK_EQUAL(error.status, 422);
        CHECK_EQUAL(error.type, "/problems/invalid-fit");
        CHECK_EQUAL(error.title, "The job is not a fit that can be computed");
        CHECK_EQUAL(error.pointers.size(), 1u);
        CHECK_EQUAL(error.pointers[0], "/curve/points/3");
        CHECK(error.detail.find("this point has 1 coordinates") != std::string::npos);
        CHECK(!error.request_id.empty());
        CHECK(!error.retry_after);
    }
    CHECK_EQUAL(THROWN(piad::ApiError, client.create(Json::array())).status, 422);
    piad::WatchOptions options;
    options.every = 2;
    options.milestones = {0.1};
    const auto error = THROWN(piad::ApiError, client.create(testing::curve()).watch([](const piad::Iteration&) {}, options));
    CHECK_EQUAL(error.status, 400);
    CHECK(!error.errors.empty() && !error.errors[0].parameter.empty());
    CHECK_EQUAL(THROWN(piad::ApiError, client.job("no/such job")).status, 404);
}

TEST(a_job_without_a_result) {
    auto input = testing::endless();
    auto running = Client(testing::server().url()).create(input);
    running.watch([](const piad::Iteration&) { return false; });
    CHECK_EQUAL(running.cancel().state, "cancelled");
    CHECK_EQUAL(running.cancel().state, "cancelled");
    auto finished = Client(testing::server().url()).create(testing::curve());
    finished.wait();
    CHECK_EQUAL(THROWN(piad::ApiError, finished.cancel()).type, "/problems/already-ended");
    // The cancelled job has computed an iteration.
    CHECK_EQUAL(running.result().state, "cancelled");
    const std::string failed = R"({"id":"j","kind":"curve","state":"failed","progress":0,"problem":{"type":"/problems/overflow","title":"","status":500,"detail":"too large"}})";
    const ScriptedServer server({says("201 Created", failed)});
    const auto error = THROWN(piad::JobFailed, Client(server.url()).fit(testing::curve()));
    CHECK_EQUAL(error.id, "j");
    CHECK_EQUAL(error.state, "failed");
    CHECK_EQUAL(error.problem->type, "/problems/overflow");
}

TEST(a_request_is_sent_again_with_the_same_key) {
    const ScriptedServer server({says("503 Service Unavailable", "busy", "Retry-After: 1\r\n"), says("502 Bad Gateway", ""), [](int) {}, says("201 Created", job)});
    const auto begin = std::chrono::steady_clock::now();
    CHECK_EQUAL(Client(server.url()).create(testing::curve()).id(), "j");
    CHECK(seconds_since(begin) >= 1);
    const auto requests = server.requests();
    CHECK_EQUAL(requests.size(), 4u);
    const auto key = header(requests[0], "Idempotency-Key");
    CHECK_EQUAL(key.size(), 36u);
    for (const auto& request : requests) CHECK_EQUAL(header(request, "Idempotency-Key"), key);
    Client(server.url()).create(testing::curve());
    CHECK(header(server.requests().back(), "Idempotency-Key") != key);
}

TEST(a_server_without_room_is_given_up) {
    piad::ClientOptions options;
    options.attempts = 3;
    const ScriptedServer server({says("429 Too Many Requests", "no room")});
    const auto error = THROWN(piad::ApiError, Client(server.url(), options).create(testing::curve()));
    CHECK_EQUAL(error.status, 429);
    CHECK_EQUAL(error.type, "about:blank");
    CHECK_EQUAL(error.detail, "no room");
    CHECK_EQUAL(server.requests().size(), 3u);
    // A delay too long to wait for.
    const ScriptedServer tomorrow({says("503 Service Unavailable", "", "Retry-After: 86400\r\n")});
    CHECK_EQUAL(THROWN(piad::ApiError, Client(tomorrow.url()).create(testing::curve())).retry_after.value_or(0), 86400.0);
    CHECK_EQUAL(tomorrow.requests().size(), 1u);
}

TEST(the_lost_answer_to_a_removal) {
    const std::string gone = R"({"type":"/problems/unknown-job","title":"","status":404,"detail":""})";
    const std::string problem = "Content-Type: application/problem+json\r\n";
    const ScriptedServer server({says("200 OK", job), [](int) {}, says("404 Not Found", gone, problem)});
    auto one = Client(server.url()).job("j");
    one.remove();
    CHECK_EQUAL(server.requests().size(), 3u);
    // For the first attempt it is an error.
    CHECK_EQUAL(THROWN(piad::ApiError, one.remove()).type, "/problems/unknown-job");
}

TEST(servers_of_other_kinds) {
    const ScriptedServer other([] {
        return std::vector<ScriptedServer::Answer>{[](int peer) { testing::send_all(peer, "SSH-2.0-OpenSSH_9.2\r\n"); }};
    }());
    THROWN(piad::ProtocolError, Client(other.url()).create(testing::curve()));
    const ScriptedServer page({says("200 OK", "<html>", "Content-Type: text/html\r\n")});
    THROWN(piad::ProtocolError, Client(page.url()).create(testing::curve()));
    THROWN(piad::ProtocolError, Client(page.url()).watch(testing::curve(), [](const piad::Iteration&) {}));
    const ScriptedServer empty({says("200 OK", "{}")});
    THROWN(piad::ProtocolError, Client(empty.url()).fit(testing::curve()));
    CHECK_EQUAL(page.requests().size(), 2u);
}

TEST(a_server_that_is_silent) {
    const ScriptedServer server({[](int peer) {
                                     std::array<char, 1> byte{};
                                     static_cast<void>(::read(peer, byte.data(), 1));
                                 },
                                 says("200 OK", job)});
    piad::ClientOptions options;
    options.timeout = std::chrono::milliseconds(300);
    const auto begin = std::chrono::steady_clock::now();
    CHECK_EQUAL(Client(server.url(), options).job("j").id(), "j");
    CHECK(seconds_since(begin) >= 0.5);
    CHECK_EQUAL(server.requests().size(), 2u);
}
