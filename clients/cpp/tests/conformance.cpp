// conformance SCENARIO URL TOKEN: runs one scenario with the JSON document on stdin through the
// client, and prints one JSON object. Each client of the project has this program; a test compares
// their outputs.

#include <chrono>
#include <cstdio>
#include <exception>
#include <iostream>
#include <iterator>
#include <numeric>
#include <string>
#include <thread>

#include "piad.hpp"

namespace {

using piad::Json;

struct Scenario {
    std::string name;
    std::string url;
    std::string token;
    Json input;

    piad::Client client() const { return client(token); }

    piad::Client client(const std::string& with) const {
        piad::ClientOptions options;
        options.token = with;
        return piad::Client(url, options);
    }
};

Json fit_of(piad::Job& job) {
    const auto result = job.result();
    const auto& knots = result.knots();
    return {{"state", result.state},
            {"iteration", result.iteration},
            {"error", result.error.max},
            {"control_points", result.control_points},
            {"knots", knots.empty() ? Json() : Json(knots)}};
}

Json fit(const Scenario& scenario) {
    auto job = scenario.client().create(scenario.input);
    job.wait();
    return fit_of(job);
}

// Summarises a stream; `each` is called for each iteration.
template <class Each>
Json watched(const Scenario& scenario, const Each& each) {
    Json numbers = Json::array();
    std::vector<double> first;
    std::vector<double> last;
    const auto end = scenario.client().watch(scenario.input, [&](const piad::Iteration& iteration) {
        if (numbers.empty()) first = iteration.control_points;
        last = iteration.control_points;
        numbers.push_back(iteration.number);
        each(iteration);
    });
    return {{"numbers", numbers}, {"first", first}, {"last", last}, {"state", end->state}};
}

Json watch(const Scenario& scenario) {
    return watched(scenario, [](const piad::Iteration&) {});
}

Json resume(const Scenario& scenario) {
    return watched(scenario, [](const piad::Iteration& iteration) {
        if (iteration.number == 5) std::cout << "ready" << std::endl;
    });
}

Json slow(const Scenario& scenario) {
    auto all = watched(scenario, [](const piad::Iteration&) { std::this_thread::sleep_for(std::chrono::milliseconds(20)); });
    return {{"numbers", all["numbers"]}, {"state", all["state"]}};
}

Json large(const Scenario& scenario) {
    Json numbers = Json::array();
    std::vector<double> last;
    piad::WatchOptions options;
    options.encoding = "base64";
    scenario.client().watch(
        scenario.input,
        [&](const piad::Iteration& iteration) {
            numbers.push_back(iteration.number);
            last = iteration.control_points;
        },
        options);
    return {{"numbers", numbers}, {"count", last.size()}, {"sum", std::accumulate(last.begin(), last.end(), 0.0)}};
}

Json differences(const Scenario& scenario) {
    Json numbers = Json::array();
    Json points = Json::array();
    piad::WatchOptions options;
    options.encoding = "delta";
    const auto end = scenario.client().watch(
        scenario.input,
        [&](const piad::Iteration& iteration) {
            numbers.push_back(iteration.number);
            points.push_back(iteration.control_points);
        },
        options);
    return {{"numbers", numbers}, {"points", points}, {"state", end->state}};
}

Json cancel(const Scenario& scenario) {
    auto job = scenario.client().create(scenario.input);
    job.watch([](const piad::Iteration&) { return false; });
    job.cancel();
    const auto state = job.refresh().state;
    return {{"state", state}, {"again", job.cancel().state}};
}

Json edit(const Scenario& scenario) {
    auto job = scenario.client().create(scenario.input.at("job"));
    job.wait();
    auto edited = job.edit(scenario.input.at("edit"));
    edited.wait();
    auto output = fit_of(edited);
    output["parent"] = job.id();
    output["is_parent"] = edited.status().parent && edited.status().parent->id == job.id();
    return output;
}

Json errors(const Scenario& scenario) {
    try {
        scenario.client().create(scenario.input);
    } catch (const piad::ApiError& error) {
        return {{"status", error.status}, {"type", error.type}, {"pointers", error.pointers}, {"detail", error.detail}};
    }
    throw std::runtime_error("the server took a request that is wrong");
}

Json tokens(const Scenario& scenario) {
    std::string without;
    try {
        scenario.client("").create(scenario.input);
    } catch (const piad::ApiError& error) {
        without = error.type;
    }
    auto job = scenario.client().create(scenario.input);
    return {{"without", without}, {"with", job.wait().state}};
}

Json run(const Scenario& scenario) {
    if (scenario.name == "fit") return fit(scenario);
    if (scenario.name == "watch") return watch(scenario);
    if (scenario.name == "resume") return resume(scenario);
    if (scenario.name == "cancel") return cancel(scenario);
    if (scenario.name == "edit") return edit(scenario);
    if (scenario.name == "errors") return errors(scenario);
    if (scenario.name == "tokens") return tokens(scenario);
    if (scenario.name == "large") return large(scenario);
    if (scenario.name == "differences") return differences(scenario);
    if (scenario.name == "slow") return slow(scenario);
    throw std::runtime_error("there is no scenario " + scenario.name);
}

}  // namespace

int main(int argc, char** argv) try {
    if (argc != 4) throw std::runtime_error("usage: conformance SCENARIO URL TOKEN < document.json");
    const std::string document(std::istreambuf_iterator<char>(std::cin), {});
    std::cout << run({argv[1], argv[2], argv[3], Json::parse(document)}).dump() << std::endl;
    return 0;
} catch (const std::exception& error) {
    std::cerr << "conformance: " << error.what() << std::endl;
    return 1;
}
