// Includes the header with macros of common names, as in X11, Windows, macOS and OpenCASCADE.
// Linking the program checks that it can be included in several files.

#include <curl/curl.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
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
#include <vector>

#define Handle(Class) Class*
#define Status int
#define Bool int
#define None 0L
#define Success 0
#define Always 2
#define min(a, b) (((a) < (b)) ? (a) : (b))
#define max(a, b) (((a) > (b)) ? (a) : (b))
#define check(assertion)
#define verify(assertion)
#define require(assertion, label)
#define small char
#define interface struct
#define DELETE 1
#define ERROR 0
#define IN
#define OUT
#define signals public
#define slots
#define emit

#include "piad.hpp"

#undef Handle
#undef Status
#undef Bool
#undef None
#undef Success
#undef Always
#undef min
#undef max
#undef check
#undef verify
#undef require
#undef small
#undef interface
#undef DELETE
#undef ERROR
#undef IN
#undef OUT
#undef signals
#undef slots
#undef emit

#include "check.hpp"
#include "jobs.hpp"
#include "server.hpp"

TEST(beside_macros_with_common_names) {
    const piad::Client client(testing::server().url());
    CHECK_EQUAL(client.fit(testing::curve(4)).state, "converged");
}
