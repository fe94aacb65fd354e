// Requests that several tests send.

#ifndef PIAD_TESTS_JOBS_HPP
#define PIAD_TESTS_JOBS_HPP

#include <cmath>
#include <vector>

#include "piad.hpp"

namespace testing {

inline piad::Json points(std::size_t count) {
    piad::Json all = piad::Json::array();
    for (std::size_t i = 0; i < count; ++i) {
        const double t = static_cast<double>(i) / 10;
        all.push_back({t, std::sin(t), std::cos(2 * t)});
    }
    return all;
}

inline piad::Json curve(std::size_t count = 12) { return {{"curve", {{"points", points(count)}}}}; }

// Of 6 rows and 5 columns.
inline piad::Json surface() {
    piad::Json rows = piad::Json::array();
    for (int i = 0; i < 6; ++i) {
        piad::Json row = piad::Json::array();
        for (int j = 0; j < 5; ++j) row.push_back({i, j, std::sin(i) * std::cos(j)});
        rows.push_back(row);
    }
    return {{"surface", {{"points", rows}}}};
}

// A fit with exactly this number of iterations.
inline piad::Json iterations(std::uint64_t count, std::size_t size = 12) {
    auto job = curve(size);
    job["stop"] = {{"tolerance", 0}, {"max_iterations", count}};
    return job;
}

// A fit that runs until it is cancelled.
inline piad::Json endless() { return iterations(1000000000); }

}  // namespace testing

#endif
