// A minimal test framework: CHECK and a list of tests.

#ifndef PIAD_TESTS_CHECK_HPP
#define PIAD_TESTS_CHECK_HPP

#include <functional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace testing {

struct Test {
    std::string name;
    std::function<void()> run;
};

inline std::vector<Test>& tests() {
    static std::vector<Test> all;
    return all;
}

struct Registration {
    Registration(const char* name, std::function<void()> run) { tests().push_back({name, std::move(run)}); }
};

[[noreturn]] inline void fail(const char* file, int line, const std::string& what) {
    std::ostringstream message;
    message << file << ":" << line << ": " << what;
    throw std::logic_error(message.str());
}

// Returns the exception of this type thrown by `call`; fails the test if there is none.
template <class Kind, class Call>
Kind thrown(const char* file, int line, const Call& call) {
    try {
        call();
    } catch (const Kind& error) {
        return error;
    }
    fail(file, line, "nothing was thrown");
}

}  // namespace testing

#define CHECK(condition) \
    do { \
        if (!(condition)) ::testing::fail(__FILE__, __LINE__, #condition); \
    } while (false)

#define CHECK_EQUAL(left, right) \
    do { \
        const auto left_ = (left); \
        const auto right_ = (right); \
        if (!(left_ == right_)) { \
            std::ostringstream what_; \
            what_ << #left << " is " << left_ << ", not " << right_; \
            ::testing::fail(__FILE__, __LINE__, what_.str()); \
        } \
    } while (false)

#define THROWN(Kind, ...) ::testing::thrown<Kind>(__FILE__, __LINE__, [&] { __VA_ARGS__; })

#define TEST(name) \
    static void test_##name(); \
    static const ::testing::Registration registration_##name(#name, test_##name); \
    static void test_##name()

#endif
