// A server with scripted responses: one for each connection.

#ifndef PIAD_TESTS_SCRIPTED_HPP
#define PIAD_TESTS_SCRIPTED_HPP

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <functional>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace testing {

class ScriptedServer {
public:
    // Writes a response to the socket, which is then closed.
    using Answer = std::function<void(int)>;

    // The last response is repeated for further connections.
    explicit ScriptedServer(std::vector<Answer> answers) : answers_(std::move(answers)) {
        listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        socklen_t length = sizeof address;
        if (::bind(listener_, reinterpret_cast<sockaddr*>(&address), length) != 0 || ::listen(listener_, 8) != 0 ||
            ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &length) != 0) {
            throw std::runtime_error("there is no port");
        }
        url_ = "http://127.0.0.1:" + std::to_string(ntohs(address.sin_port));
        thread_ = std::thread([this] { serve(); });
    }
    ~ScriptedServer() {
        ended_ = true;
        thread_.join();
        ::close(listener_);
    }
    ScriptedServer(const ScriptedServer&) = delete;
    ScriptedServer& operator=(const ScriptedServer&) = delete;

    const std::string& url() const { return url_; }

    // The heads and bodies of the requests.
    std::vector<std::string> requests() const {
        const std::lock_guard<std::mutex> lock(mutex_);
        return requests_;
    }

private:
    void serve() {
        for (std::size_t count = 0; !ended_;) {
            pollfd waiting{listener_, POLLIN, 0};
            if (::poll(&waiting, 1, 20) != 1) continue;
            const int peer = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
            receive(peer);
            answers_[std::min(count++, answers_.size() - 1)](peer);
            ::close(peer);
        }
    }

    // Reads a complete request, so that closing the socket does not reset the connection.
    void receive(int peer) {
        std::string request;
        std::array<char, 4096> buffer{};
        std::size_t wanted = std::string::npos;
        while (request.size() < wanted) {
            const auto length = ::read(peer, buffer.data(), buffer.size());
            if (length <= 0) break;
            request.append(buffer.data(), static_cast<std::size_t>(length));
            const auto end = request.find("\r\n\r\n");
            const auto field = request.find("Content-Length: ");
            if (end != std::string::npos) wanted = end + 4 + (field < end ? std::stoul(request.substr(field + 16)) : 0);
        }
        const std::lock_guard<std::mutex> lock(mutex_);
        requests_.push_back(request);
    }

    std::vector<Answer> answers_;
    int listener_ = -1;
    std::string url_;
    mutable std::mutex mutex_;
    std::vector<std::string> requests_;
    std::atomic<bool> ended_{false};
    std::thread thread_;
};

// Writes all of it; returns false if the peer does not read.
inline bool send_all(int peer, const std::string& text) {
    std::size_t sent = 0;
    while (sent < text.size()) {
        const auto length = ::send(peer, text.data() + sent, text.size() - sent, MSG_NOSIGNAL);
        if (length <= 0) return false;
        sent += static_cast<std::size_t>(length);
    }
    return true;
}

// A response with this status and body.
inline ScriptedServer::Answer says(const std::string& status, const std::string& body, const std::string& headers = "") {
    return [=](int peer) {
        send_all(peer, "HTTP/1.1 " + status + "\r\nConnection: close\r\nContent-Length: " + std::to_string(body.size()) + "\r\n" + headers + "\r\n" + body);
    };
}

// An event stream that disconnects after these events. Its chunk is incomplete, so this is not a
// regular end.
inline ScriptedServer::Answer streams(const std::string& events) {
    return [=](int peer) {
        send_all(peer, "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nTransfer-Encoding: chunked\r\n\r\nffffff\r\n" + events);
    };
}

}  // namespace testing

#endif
