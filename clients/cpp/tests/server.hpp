// A real server: the program in PIAD_PROGRAM, on a free port of this machine.

#ifndef PIAD_TESTS_SERVER_HPP
#define PIAD_TESTS_SERVER_HPP

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace testing {

class Server {
public:
    // `token`: required by the server, if not empty. `store`: a file of jobs, for a server that is
    // restarted.
    explicit Server(std::string token = "", std::string store = ":memory:") : token_(std::move(token)), store_(std::move(store)) { start(); }
    ~Server() { stop(SIGKILL); }
    Server(const Server&) = delete;
    Server& operator=(const Server&) = delete;

    std::string url() const { return "http://" + address_; }

    // Terminates the server with a signal.
    void stop(int signal) {
        if (process_ <= 0) return;
        ::kill(process_, signal);
        ::waitpid(process_, nullptr, 0);
        process_ = 0;
        // The log ends when the program ends.
        reader_.join();
    }

    // Restarts it on the same port.
    void start() {
        std::array<int, 2> log{};
        if (::pipe2(log.data(), O_CLOEXEC) != 0) throw std::runtime_error("there is no pipe");
        const char* const program = std::getenv("PIAD_PROGRAM");
        if (program == nullptr) throw std::runtime_error("PIAD_PROGRAM is not set");
        std::vector<std::string> words{program, "--listen", address_, "--store", store_, "--log-format", "json", "--max-iterations", "1000000000"};
        std::vector<char*> arguments;
        for (auto& word : words) arguments.push_back(word.data());
        arguments.push_back(nullptr);
        std::string setting = "PIAD_TOKEN=" + token_;
        std::vector<char*> environment;
        if (!token_.empty()) environment.push_back(setting.data());
        environment.push_back(nullptr);
        process_ = ::fork();
        if (process_ == 0) {
            ::dup2(log[1], STDERR_FILENO);
            ::execve(program, arguments.data(), environment.data());
            ::_exit(127);
        }
        ::close(log[1]);
        wait_for_address(log[0]);
        // A full pipe would block the server.
        reader_ = std::thread([file = log[0]] {
            std::array<char, 4096> buffer{};
            while (::read(file, buffer.data(), buffer.size()) > 0) {
            }
            ::close(file);
        });
    }

private:
    void wait_for_address(int file) {
        const std::string mark = "listening on http://";
        std::string log;
        char c = 0;
        while (::read(file, &c, 1) == 1) {
            log += c;
            if (c != '\n') continue;
            const auto begin = log.find(mark);
            if (begin != std::string::npos) {
                const auto from = begin + mark.size();
                address_ = log.substr(from, log.find_first_not_of("0123456789.:", from) - from);
                return;
            }
        }
        throw std::runtime_error("the server has not started: " + log);
    }

    std::string token_;
    std::string store_;
    std::string address_ = "127.0.0.1:0";
    pid_t process_ = 0;
    std::thread reader_;
};

// A shared server for tests without special needs.
inline Server& server() {
    static Server one;
    return one;
}

}  // namespace testing

#endif
