// Many fits in one request.

#include <signal.h>

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "check.hpp"
#include "jobs.hpp"
#include "piad.hpp"
#include "server.hpp"

using piad::BatchItem;
using piad::Client;
using piad::Json;

namespace {

Client client() { return Client(testing::server().url()); }

Json wave(int number) {
    Json points = Json::array();
    for (int i = 0; i < 50; ++i) points.push_back({i / 7.0, std::sin(i / 7.0 + number)});
    return {{"name", "wave " + std::to_string(number)}, {"curve", {{"points", points}}}};
}

std::vector<Json> waves(int count) {
    std::vector<Json> all;
    for (int number = 0; number < count; ++number) all.push_back(wave(number));
    return all;
}

}  // namespace

TEST(items_of_a_batch_are_what_fits_are) {
    auto weighted = testing::curve(4);
    weighted["curve"]["weights"] = {1, 2, 1, 1};
    auto short_one = testing::curve();
    short_one["stop"] = {{"tolerance", 1e-12}, {"max_iterations", 1}};
    const std::vector<Json> jobs{testing::curve(), testing::surface(), weighted, {{"curve", {{"points", {{0, 0}, {1, 1}, {1, 1}}}}}}, short_one};
    std::vector<BatchItem> items;
    const auto totals = client().batch(jobs, [&](const BatchItem& item) { items.push_back(item); });
    CHECK_EQUAL(totals.items, 5u);
    CHECK_EQUAL(totals.converged, 3u);
    CHECK_EQUAL(totals.failed, 2u);
    for (std::size_t i = 0; i < 3; ++i) {
        const auto alone = client().fit(jobs[i]);
        CHECK_EQUAL(items[i].index, i);
        CHECK(items[i].result->control_points == alone.control_points);
        CHECK(items[i].result->weights == alone.weights);
        CHECK(items[i].result->knots() == alone.knots());
        CHECK_EQUAL(items[i].error->max, alone.error.max);
        CHECK_EQUAL(*items[i].iteration, alone.iteration);
        CHECK(!items[i].problem);
    }
    CHECK_EQUAL(items[3].state, "failed");
    CHECK_EQUAL(items[3].problem->pointers.at(0), "/items/3/curve/points/2");
    CHECK(!items[3].result);
    CHECK_EQUAL(items[4].problem->type, "/problems/not-converged");
    CHECK_EQUAL(items[4].result->iteration, 1u);
}

TEST(thousands_of_items_come_in_order) {
    auto jobs = waves(2000);
    jobs[1500] = {{"curve", {{"points", Json::array()}}}};
    piad::BatchOptions options;
    options.defaults = {{"method", {{"kind", "least_squares"}, {"control_points", "auto"}}}, {"stop", {{"tolerance", 0.01}}}};
    std::uint64_t seen = 0;
    const auto totals = client().batch(jobs, [&](const BatchItem& item) {
        CHECK_EQUAL(item.index, seen++);
        if (item.index == 1500) {
            CHECK_EQUAL(item.problem->detail.rfind("/items/1500/curve", 0), 0u);
        } else {
            CHECK_EQUAL(item.name, "wave " + std::to_string(item.index));
            CHECK(item.result->shape[0] < 40);
        }
    }, options);
    CHECK_EQUAL(totals.items, 2000u);
    CHECK_EQUAL(totals.converged, 1999u);
    CHECK_EQUAL(client().batch(std::vector<Json>(), [](const BatchItem&) {}).items, 0u);
}

TEST(batches_that_are_left_or_refused) {
    const auto jobs = waves(500);
    const auto totals = client().batch(jobs, [](const BatchItem& item) { return item.index < 7; });
    CHECK_EQUAL(totals.items, 8u);
    THROWN(std::logic_error, client().batch(jobs, [](const BatchItem&) { throw std::logic_error("enough"); }));
    piad::BatchOptions options;
    options.defaults = {{"tolerance", 1}};
    const auto refused = THROWN(piad::ApiError, client().batch(jobs, [](const BatchItem&) {}, options));
    CHECK_EQUAL(refused.pointers.at(0), "/defaults/tolerance");
    const piad::StopSource source;
    piad::BatchOptions stopping;
    stopping.stop = source.token();
    THROWN(piad::Stopped, client().batch(jobs, [&](const BatchItem&) { source.stop(); }, stopping));
    const std::vector<Json> broken{{{"curve", {{"points", {{0, std::nan("")}}}}}}};
    THROWN(std::invalid_argument, client().batch(broken, [](const BatchItem&) {}));
}

TEST(batches_go_on_after_a_server_was_killed) {
    testing::Server server;
    std::uint64_t seen = 0;
    Client(server.url()).batch(waves(500), [&](const BatchItem& item) {
        CHECK_EQUAL(item.index, seen++);
        if (item.index != 100) return;
        server.stop(SIGKILL);
        server.start();
    });
    CHECK_EQUAL(seen, 500u);
}
