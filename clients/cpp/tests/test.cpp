// Fits, jobs and their operations, on a real server. Runs all tests, or those named.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <iostream>
#include <thread>

#include "check.hpp"
#include "jobs.hpp"
#include "piad.hpp"
#include "server.hpp"

using piad::Client;
using piad::Json;

namespace {

Client client() { return Client(testing::server().url()); }

using Shape = std::vector<std::size_t>;

}  // namespace

TEST(a_curve) {
    const auto result = client().fit(testing::curve());
    CHECK_EQUAL(result.state, "converged");
    CHECK(result.error.max > 0 && result.error.max < 1e-4);
    CHECK(result.iteration > 0);
    CHECK(!result.is_surface());
    CHECK_EQUAL(result.degree(), 3);
    // Two more control points than data, as CAD kernels store them.
    CHECK(result.shape == Shape({14, 3}));
    CHECK_EQUAL(result.control_points.size(), 42u);
    CHECK_EQUAL(result.knots().size(), 14u + 3u + 1u);
    CHECK(result.weights.empty());
    CHECK_EQUAL(result.directions[0].parameters.size(), 12u);
    // A clamped curve starts at its first data point.
    CHECK_EQUAL(result.control_points[0], 0.0);
    CHECK_EQUAL(result.control_points[2], 1.0);
}

TEST(a_surface) {
    auto job = testing::surface();
    job["surface"]["degree"] = {{"u", 3}, {"v", 2}};
    const auto result = client().fit(job);
    CHECK(result.is_surface());
    CHECK_EQUAL(result.degree(0), 3);
    CHECK_EQUAL(result.degree(1), 2);
    CHECK_EQUAL(result.shape.size(), 3u);
    CHECK_EQUAL(result.shape[2], 3u);
    CHECK_EQUAL(result.control_points.size(), result.shape[0] * result.shape[1] * 3);
    CHECK_EQUAL(result.knots(0).size(), result.shape[0] + 4);
    CHECK_EQUAL(result.knots(1).size(), result.shape[1] + 3);
    CHECK_EQUAL(result.error.at.size(), 2u);
}

// A ring of points over the unit square.
TEST(a_trimmed_surface_has_the_outline_of_its_data) {
    Json points = Json::array();
    for (int i = 0; i <= 30; ++i) {
        for (int j = 0; j <= 30; ++j) {
            const double x = i / 15.0 - 1, y = j / 15.0 - 1, radius = std::hypot(x, y);
            if (radius > 0.4 && radius < 1) points.push_back({x, y, x * y});
        }
    }
    const auto result = client().fit({
        {"surface", {{"scattered", points}, {"parameters", {{"project", "xy"}}}, {"trim", true}}},
        {"method", {{"kind", "least_squares"}, {"control_points", 6}}},
    });
    CHECK(result.trim.has_value());
    CHECK_EQUAL(result.trim->faces.size(), 1u);
    CHECK(result.trim->faces[0].holes == std::vector<std::size_t>({1}));
    CHECK_EQUAL(result.trim->loops.size(), 2u);
    CHECK(*result.trim->area > 2 && *result.trim->area < 4);
    for (const auto& loop : result.trim->loops) {
        CHECK(loop.directions[0].closed);
        CHECK_EQUAL(loop.shape[1], 2u);
        CHECK_EQUAL(loop.knots().size(), loop.shape[0] + loop.degree() + 1);
    }
    CHECK(!client().fit(testing::surface()).trim.has_value());
}

TEST(a_closed_curve_repeats_its_first_control_points) {
    const auto result = client().fit({{"curve", {{"points", {{1, 0}, {0, 1}, {-1, 0}, {0, -1}}}, {"closed", true}}}});
    CHECK(result.directions[0].closed);
    CHECK(result.shape == Shape({7, 2}));
    for (std::size_t i = 0; i < 6; ++i) CHECK_EQUAL(result.control_points[i], result.control_points[8 + i]);
    CHECK_EQUAL(result.knots().size(), 11u);
}

TEST(weights_of_a_homogeneous_fit_evolve) {
    auto job = testing::curve(4);
    job["curve"]["weights"] = {1, 2, 1, 1};
    const auto result = client().fit(job);
    CHECK_EQUAL(result.weights.size(), result.shape[0]);
    CHECK_EQUAL(result.weights.front(), 1.0);
    CHECK(std::any_of(result.weights.begin(), result.weights.end(), [](double w) { return w != 1 && w != 2; }));
    std::vector<double> last;
    client().watch(job, [&](const piad::Iteration& iteration) { last = iteration.weights; });
    CHECK(last == result.weights);
}

TEST(fixed_weights_of_a_surface_are_products) {
    auto job = testing::surface();
    job["surface"]["degree"] = 2;
    job["surface"]["weights"] = {{"u", {1, 2, 1, 3, 1, 1}}, {"v", {1, 1, 5, 1, 2}}};
    job["rational"] = "fixed";
    const auto result = client().fit(job);
    CHECK(result.shape == Shape({6, 5, 3}));
    CHECK_EQUAL(result.weights.size(), 30u);
    CHECK_EQUAL(result.weights[1 * 5 + 2], 10.0);
    CHECK_EQUAL(result.weights[3 * 5 + 4], 6.0);
    std::size_t seen = 0;
    client().watch(job, [&](const piad::Iteration& iteration) {
        CHECK(iteration.weights == result.weights);
        ++seen;
    });
    CHECK(seen > 1);
}

TEST(base64_and_json_are_the_same_to_the_last_bit) {
    for (auto job : {testing::curve(), testing::surface(), testing::curve(4)}) {
        if (job.contains("curve") && job["curve"]["points"].size() == 4) job["curve"]["weights"] = {1, 2, 1, 1};
        std::vector<piad::Iteration> binary;
        std::vector<piad::Iteration> decimal;
        piad::WatchOptions options;
        options.encoding = "base64";
        client().watch(job, [&](const piad::Iteration& iteration) { binary.push_back(iteration); }, options);
        options.encoding = "json";
        client().watch(job, [&](const piad::Iteration& iteration) { decimal.push_back(iteration); }, options);
        CHECK(binary.size() > 1);
        CHECK_EQUAL(binary.size(), decimal.size());
        for (std::size_t i = 0; i < binary.size(); ++i) {
            CHECK(binary[i].control_points == decimal[i].control_points);
            CHECK(binary[i].shape == decimal[i].shape);
            CHECK(binary[i].weights == decimal[i].weights);
            CHECK(binary[i].directions[0].knots == decimal[i].directions[0].knots);
        }
    }
}

TEST(a_fit_that_is_no_job) {
    const auto before = client().jobs({"", 1, {}});
    const auto once = client().fit_once(testing::curve());
    const auto after = client().jobs({"", 1, {}});
    CHECK_EQUAL(once.state, "converged");
    CHECK(before.size() == after.size() && (before.empty() || before[0].id() == after[0].id()));
    CHECK(once.control_points == client().fit(testing::curve()).control_points);
    const auto error = THROWN(piad::ApiError, client().fit_once(testing::iterations(3)));
    CHECK_EQUAL(error.status, 422);
    CHECK_EQUAL(error.type, "/problems/not-converged");
}

TEST(a_job_and_what_belongs_to_it) {
    auto input = testing::curve();
    input["name"] = "wing section";
    auto job = client().create(input);
    CHECK_EQUAL(job.wait().state, "converged");
    CHECK_EQUAL(job.status().name, "wing section");
    CHECK_EQUAL(job.status().kind, "curve");
    CHECK_EQUAL(job.status().progress, 1.0);
    CHECK(job.input()["curve"]["points"] == input["curve"]["points"]);
    const auto result = job.result();
    const auto last = job.iteration();
    CHECK_EQUAL(last.number, result.iteration);
    CHECK(last.control_points == result.control_points);
    CHECK(last.directions[0].knots == result.directions[0].knots);
    CHECK_EQUAL(job.iteration(2).number, 2u);
    const auto deviation = job.deviation(true);
    CHECK_EQUAL(deviation.distances.size(), 12u);
    CHECK(deviation.max <= result.error.max && deviation.percentiles.at(50) <= deviation.max);
    const auto same = client().job(job.id());
    CHECK_EQUAL(same.status().state, "converged");
}

TEST(a_file) {
    auto input = testing::curve();
    input["name"] = "wing";
    auto job = client().create(input);
    job.wait();
    const auto file = job.file("step");
    CHECK_EQUAL(file.name, "wing.step");
    CHECK_EQUAL(file.media_type, "model/step");
    CHECK_EQUAL(file.content.substr(0, 13), "ISO-10303-21;");
    piad::FileOptions options;
    options.iteration = 1;
    options.samples = "7";
    const auto table = job.file("csv", options);
    CHECK_EQUAL(std::count(table.content.begin(), table.content.end(), '\n'), 8);
}

TEST(an_edit_starts_from_its_parent) {
    auto job = client().create(testing::curve());
    job.wait();
    auto edit = job.edit({{"points", {{{"index", 5}, {"point", {0.5, 2, 0}}}}}, {"method", {{"kind", "local"}, {"indices", {4, 5, 6}}}}});
    const auto result = edit.result();
    CHECK(edit.status().parent.has_value());
    CHECK_EQUAL(edit.status().parent->id, job.id());
    CHECK(result.knots() == job.result().knots());
    CHECK(result.control_points != job.result().control_points);
}

TEST(an_ephemeral_edit_leaves_nothing_behind) {
    auto job = client().create(testing::curve(200));
    job.wait();
    const auto from = job.iteration();
    piad::WatchOptions options;
    options.from = &from;
    options.changed = true;
    const Json edit{{"points", {{{"index", 90}, {"point", {9, 2, 0}}}}},
                    {"method", {{"kind", "local"}, {"indices", {88, 89, 90, 91, 92}}}},
                    {"ephemeral", true},
                    {"session", "drag"}};
    piad::Iteration last;
    const auto end = job.edit_watch(edit, [&](const piad::Iteration& iteration) { last = iteration; }, options);
    CHECK(end.has_value());
    CHECK_EQUAL(end->state, "converged");
    CHECK(last.directions[0].knots == from.directions[0].knots);
    CHECK_EQUAL(last.control_points.size(), from.control_points.size());
    std::size_t different = 0;
    for (std::size_t i = 0; i < last.control_points.size(); ++i) different += last.control_points[i] != from.control_points[i];
    CHECK(different > 0 && different <= 5 * 3);
    CHECK(client().jobs({"", 1, {}})[0].id() == job.id());
}

TEST(jobs_are_listed_and_removed) {
    std::vector<std::string> ids;
    for (int i = 0; i < 3; ++i) {
        auto job = client().create(testing::curve());
        job.wait();
        ids.insert(ids.begin(), job.id());
    }
    const auto jobs = client().jobs({"converged", 3, {}});
    CHECK_EQUAL(jobs.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i) CHECK_EQUAL(jobs[i].id(), ids[i]);
    auto newest = jobs[0];
    newest.remove();
    CHECK_EQUAL(THROWN(piad::ApiError, newest.refresh()).type, "/problems/unknown-job");
    CHECK_EQUAL(client().jobs({"converged", 1, {}})[0].id(), ids[1]);
}

TEST(points_of_a_file) {
    const auto wing = client().read_points("NACA 2412\n1 0.0013\n0.5 0.0724\n0 0\n0.5 -0.0334\n1 -0.0013\n");
    CHECK_EQUAL(wing["curve"]["points"].size(), 5u);
    const auto result = client().fit({{"curve", wing["curve"]}});
    CHECK_EQUAL(result.state, "converged");
    CHECK(client().get("/v1/capabilities").is_object());
}

TEST(one_client_for_several_threads) {
    const Client shared = client();
    const auto expected = shared.fit(testing::curve()).control_points;
    std::vector<std::thread> threads;
    std::atomic<int> same{0};
    for (int i = 0; i < 6; ++i) {
        threads.emplace_back([&] {
            for (int k = 0; k < 5; ++k) same += shared.fit(testing::curve()).control_points == expected;
        });
    }
    for (auto& thread : threads) thread.join();
    CHECK_EQUAL(same.load(), 30);
}

TEST(tokens) {
    const std::string token = "0123456789abcdef0123456789abcdef";
    const testing::Server server(token);
    const auto error = THROWN(piad::ApiError, Client(server.url()).create(testing::curve()));
    CHECK_EQUAL(error.status, 401);
    CHECK_EQUAL(error.type, "/problems/unauthenticated");
    piad::ClientOptions options;
    options.token = token;
    auto job = Client(server.url(), options).create(testing::curve());
    CHECK_EQUAL(job.wait().state, "converged");
    CHECK(!job.ticket().empty());
    // A server without tokens issues no tickets.
    auto open = client().create(testing::curve());
    CHECK_EQUAL(THROWN(piad::ApiError, open.ticket()).type, "/problems/no-tickets");
}

int main(int argc, char** argv) {
    int failed = 0;
    int run = 0;
    for (const auto& test : testing::tests()) {
        if (argc > 1 && std::find(argv + 1, argv + argc, test.name) == argv + argc) continue;
        ++run;
        const auto begin = std::chrono::steady_clock::now();
        std::string outcome = "ok";
        try {
            test.run();
        } catch (const std::exception& error) {
            outcome = std::string("FAILED: ") + error.what();
            ++failed;
        }
        const auto time = std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::steady_clock::now() - begin);
        std::cout << test.name << ": " << outcome << " (" << time.count() << " ms)" << std::endl;
    }
    std::cout << run << " tests, " << failed << " failed" << std::endl;
    return failed == 0 && run > 0 ? 0 : 1;
}
