// Fits a curve over gRPC with code generated from proto/piad/v1/fitting.proto, without JSON or
// piad.hpp.
//
//     grpc [HOST:PORT]         # such as 127.0.0.1:8080; a token is taken from PIAD_TOKEN
//
// If the connection breaks or the server stops, the stream resumes after the last iteration
// received.

#include <grpcpp/grpcpp.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>

#include "piad/v1/fitting.grpc.pb.h"
#include "piad/v1/fitting.pb.h"

namespace {

namespace v1 = piad::v1;

// Call credentials require TLS: without it a token is sent as plain metadata.
void authorise(grpc::ClientContext& context) {
    if (const char* token = std::getenv("PIAD_TOKEN")) context.AddMetadata("authorization", std::string("Bearer ") + token);
}

v1::JobInput section() {
    v1::JobInput input;
    input.set_name("section");
    auto& curve = *input.mutable_curve();
    curve.set_dimension(2);
    for (int i = 0; i <= 40; ++i) {
        curve.add_points(i / 4.0);
        curve.add_points(std::sin(i / 8.0));
    }
    input.mutable_stop()->set_tolerance(1e-9);
    return input;
}

std::string random_key() {
    std::random_device device;
    return std::to_string(device()) + "-" + std::to_string(device()) + "-" + std::to_string(device()) + "-" + std::to_string(device());
}

// Creates a job; retries with the same key create no second one.
v1::Job create(v1::FittingService::Stub& stub, const v1::JobInput& input) {
    v1::CreateJobRequest request;
    *request.mutable_input() = input;
    request.set_idempotency_key(random_key());
    v1::CreateJobResponse response;
    grpc::Status status;
    for (int attempt = 1; attempt <= 3; ++attempt) {
        grpc::ClientContext context;
        authorise(context);
        status = stub.CreateJob(&context, request, &response);
        if (status.error_code() != grpc::StatusCode::UNAVAILABLE) break;
        std::this_thread::sleep_for(std::chrono::milliseconds(500 * attempt));
    }
    if (!status.ok()) throw std::runtime_error("CreateJob: " + status.error_message());
    return response.job();
}

// Watches a job until it ends, across broken connections; returns its last iteration.
v1::Iteration watch(v1::FittingService::Stub& stub, const std::string& id) {
    v1::Iteration last;
    std::optional<std::uint64_t> seen;
    for (int failures = 0; failures < 8;) {
        v1::WatchJobRequest request;
        request.set_id(id);
        if (seen) request.set_resume_after(*seen);
        grpc::ClientContext context;
        authorise(context);
        const auto reader = stub.WatchJob(&context, request);
        v1::WatchJobResponse event;
        while (reader->Read(&event)) {
            if (event.has_iteration()) {
                last = event.iteration();
                seen = last.iteration();
                failures = 0;
                std::cout << "iteration " << last.iteration() << ": " << last.error().max() << "\n";
            }
            if (event.has_end()) {
                if (event.end().state() != v1::JOB_STATE_CONVERGED) throw std::runtime_error("the fit has not converged");
                return last;
            }
        }
        const auto status = reader->Finish();
        if (!status.ok() && status.error_code() != grpc::StatusCode::UNAVAILABLE) throw std::runtime_error("WatchJob: " + status.error_message());
        ++failures;
        std::this_thread::sleep_for(std::chrono::seconds(failures));
    }
    throw std::runtime_error("lost the connection to the server");
}

v1::FitResult result(v1::FittingService::Stub& stub, const std::string& id) {
    v1::GetResultRequest request;
    request.set_id(id);
    v1::GetResultResponse response;
    grpc::ClientContext context;
    authorise(context);
    const auto status = stub.GetResult(&context, request, &response);
    if (!status.ok()) throw std::runtime_error("GetResult: " + status.error_message());
    return response.result();
}

}  // namespace

int main(int argc, char** argv) try {
    grpc::ChannelArguments arguments;
    // Messages are as large as the data; the default limit of gRPC is 4 MB.
    arguments.SetMaxReceiveMessageSize(-1);
    const auto channel = grpc::CreateCustomChannel(argc > 1 ? argv[1] : "127.0.0.1:8080", grpc::InsecureChannelCredentials(), arguments);
    const auto stub = v1::FittingService::NewStub(channel);
    const auto job = create(*stub, section());
    const auto last = watch(*stub, job.id());
    const auto fit = result(*stub, job.id());
    const auto& net = fit.control_net();
    if (net.points_size() != last.control_net().points_size() || fit.u().knots_size() != static_cast<int>(net.rows()) + static_cast<int>(fit.u().degree()) + 1) {
        throw std::runtime_error("the result is not the last iteration");
    }
    std::cout << net.rows() << " control points of degree " << fit.u().degree() << ", error " << fit.error().max() << std::endl;
    return 0;
} catch (const std::exception& error) {
    std::cerr << "grpc: " << error.what() << std::endl;
    return 1;
}
