#include "firmware/session/device_server.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <thread>

#include "firmware/acquire/safe_state.h"
#include "firmware/protocol/validate.h"
#include "firmware/session/connection.h"
#include "firmware/session/feature_table.h"
#include "firmware/session/run_stream.h"

namespace stria {
namespace {

constexpr Milliseconds kHealthPeriod{50};
constexpr Milliseconds kStopSlice{20};
constexpr Milliseconds kHandover{500};  // until the controller's leaving is noticed

Response refusal(std::string why) {
    Response response;
    response.ok = false;
    response.error = std::move(why);
    return response;
}

}  // namespace

class DeviceServer::State : public ConnectionOwner {
  public:
    State(ServedDevice device, const ServerOptions& options)
        : device_(std::move(device)),
          options_(options),
          settings_{device_.acquire, 1.0},
          features_(common_features(device_, settings_)),
          machine_([this] { run_machine(); }) {}

    ~State() override {
        {
            const std::lock_guard lock(mutex_);
            quitting_ = true;
            stop_ = true;
            for (const auto& client : clients_) client->close();
            changed_.notify_all();
        }
        machine_.join();
        clients_.clear();
        (void)make_safe(device_.devices);  // nobody is left to tell
    }

    void serve(std::unique_ptr<ByteStream> stream) {
        const ConnectionOptions options{.silence = options_.heartbeat_timeout,
                                        .max_data_bytes = options_.max_data_bytes};
        auto client = std::make_shared<Connection>(std::move(stream), *this, options);
        std::vector<std::shared_ptr<Connection>> finished;  // destroyed after the lock is given up
        const std::lock_guard lock(mutex_);
        const auto gone = std::partition(clients_.begin(), clients_.end(),
                                         [](const auto& c) { return !c->is_finished(); });
        finished.assign(gone, clients_.end());
        clients_.erase(gone, clients_.end());
        clients_.push_back(client);
        client->start();
    }

    std::size_t client_count() const {
        const std::lock_guard lock(mutex_);
        return static_cast<std::size_t>(
            std::count_if(clients_.begin(), clients_.end(),
                          [](const auto& client) { return !client->is_finished(); }));
    }

    bool is_running() const {
        const std::lock_guard lock(mutex_);
        return run_ != nullptr;
    }

    Response answer(Connection& client, const Request& request) override {
        std::unique_lock lock(mutex_);
        if (request.verb == RequestVerb::hello) return hello(client, request, lock);
        if (!client.said_hello) return refusal("expected a hello first");
        Response response;
        response.role = client.role;
        switch (request.verb) {
            case RequestVerb::describe:
                response.snapshot = snapshot(ScanPlan(idle_plan()));
                break;
            case RequestVerb::features:
                return read_features(request);
            case RequestVerb::set_feature:
                return set_feature(client, request);
            case RequestVerb::start:
                return start(client, request);
            case RequestVerb::stop:
                stop_ = true;
                break;
            case RequestVerb::ack:
                return acknowledge(request);
            case RequestVerb::select:
                client.channels = request.channels;
                break;
            case RequestVerb::set_paths:
                return set_paths(client, request);
            case RequestVerb::hello:
            case RequestVerb::heartbeat:
            case RequestVerb::credit:
                break;
        }
        return response;
    }

    void lost(Connection& client, const std::string& why) override {
        const std::lock_guard lock(mutex_);
        if (controller_ != &client) return;
        controller_ = nullptr;
        changed_.notify_all();
        settings_.acquire.path_tables.clear();  // they were of its calibration
        if (run_ == nullptr) return;
        stop_reason_ = client.client + " was lost: " + why;
        stop_ = true;
    }

  private:
    /// A plan that was not given yet: the whole travel in a hundred steps.
    ScanPlan idle_plan() const {
        const AxisInfo axis = device_.devices.axis.info();
        ScanPlan plan;
        plan.mode =
            device_.acquire.spacetime_per_pixel ? StripeMode::spacetime : StripeMode::spatial;
        plan.from = axis.min_s;
        plan.to = axis.max_s > axis.min_s ? axis.max_s : axis.min_s + 1;
        plan.step = (plan.to - plan.from) / 100;
        return plan;
    }

    Snapshot snapshot(const ScanPlan& plan) const {
        return {kProtocolVersion,
                device_.devices.clock.now(),
                describe(device_),
                features_.all(),
                plan,
                device_.model_text};
    }

    /// Who asks for control while another has it is kept waiting for a moment: that other one may
    /// have closed already, and only its reading thread does not know yet.
    Response hello(Connection& client, const Request& request, std::unique_lock<std::mutex>& lock) {
        client.said_hello = true;
        if (!request.client.empty()) client.client = request.client;
        if (request.role == Role::control)
            changed_.wait_for(lock, kHandover, [&] {
                return controller_ == nullptr || controller_ == &client || quitting_;
            });
        Response response;
        if (request.role == Role::control && controller_ == nullptr) {
            controller_ = &client;
            client.role = Role::control;
            client.channels = kSelectData | kSelectHealth;
        } else if (request.role == Role::control && controller_ != &client) {
            response.error = controller_->client + " has control; this client watches";
        }
        response.role = client.role;
        return response;
    }

    Response read_features(const Request& request) const {
        Response response;
        if (request.name.empty()) {
            response.features = features_.all();
            return response;
        }
        const auto feature = features_.get(request.name);
        if (!feature) return refusal(feature.failure().message);
        response.features = {*feature};
        return response;
    }

    Status may_change(const Connection& client) const {
        if (&client != controller_)
            return Failure{controller_ != nullptr ? controller_->client + " has control"
                                                  : std::string("this client only watches")};
        if (run_ != nullptr) return Failure{"a run is going on"};
        return {};
    }

    Response set_feature(const Connection& client, const Request& request) {
        if (Status may = may_change(client); !may) return refusal(may.failure().message);
        const auto feature = features_.set(request.name, request.value);
        if (!feature) return refusal(feature.failure().message);
        Response response;
        response.role = client.role;
        response.features = {*feature};
        return response;
    }

    Response set_paths(const Connection& client, const Request& request) {
        if (Status may = may_change(client); !may) return refusal(may.failure().message);
        std::vector<PathTable>& tables = settings_.acquire.path_tables;
        if (request.paths) {
            const std::string why = check_paths(*request.paths, device_.devices, settings_.acquire);
            if (!why.empty()) return refusal(why);
            std::erase_if(tables, [&](const PathTable& table) {
                return table.laser_id == request.paths->laser_id;
            });
            tables.push_back(*request.paths);
        } else {
            tables.clear();
        }
        Response response;
        response.role = client.role;
        return response;
    }

    Response start(Connection& client, const Request& request) {
        if (Status may = may_change(client); !may) return refusal(may.failure().message);
        const ScanPlan& plan = *request.plan;  // validate() has seen it
        if (plan.laser_power > settings_.laser_power)
            return refusal("laser_power = " + std::to_string(plan.laser_power) +
                           ": expected at most the feature LaserPower = " +
                           std::to_string(settings_.laser_power));
        if (std::string why = validate(plan, device_.devices, settings_.acquire); !why.empty())
            return refusal(why);
        client.outbox().clear_data();  // the last run's, never asked for
        stop_ = false;
        stop_reason_.clear();
        status_ = {};
        run_ = std::make_unique<ScanPlan>(plan);
        ++run_number_;
        changed_.notify_all();
        Response response;
        response.role = client.role;
        response.run = run_number_;
        return response;
    }

    std::string spool_path(std::uint32_t run) const {
        return options_.spool_folder + "/run-" + std::to_string(run) + ".stria";
    }

    Response acknowledge(const Request& request) {
        if (request.run == 0 || request.run > run_number_ ||
            (run_ != nullptr && request.run == run_number_))
            return refusal("there is no finished run " + std::to_string(request.run));
        if (!options_.spool_folder.empty()) std::remove(spool_path(request.run).c_str());
        return {};
    }

    void run_machine() {
        std::unique_lock lock(mutex_);
        while (true) {
            changed_.wait(lock, [&] { return quitting_ || run_ != nullptr; });
            if (quitting_) return;
            const ScanPlan plan = *run_;
            const Snapshot first = snapshot(plan);
            const AcquireOptions options = settings_.acquire;
            const std::uint32_t number = run_number_;
            lock.unlock();
            carry_out(plan, first, options, number);
            lock.lock();
        }
    }

    /// One run with its messages, on the machine's thread.
    void carry_out(const ScanPlan& plan, const Snapshot& first, const AcquireOptions& options,
                   std::uint32_t number) {
        RunStream stream(
            number, [this](const SharedMessage& message) { return send_data(message); },
            [this](const AcquireStatus& status) { take_status(status); });
        AcquireReport report;
        Status begun;
        if (!options_.spool_folder.empty()) begun = stream.spool_to(spool_path(number));
        if (begun) begun = stream.begin(first);
        for (const PathTable* table : paths_followed(plan, options))
            if (begun) begun = stream.take_path_table(*table);
        if (begun)
            report = run_plan(plan, device_.devices, options, stream, stop_);
        else
            report.reason = begun.failure().message;
        End end{report.complete, report.reason, report.status.frames, report.status.frames_dropped,
                report.status.emission_s};
        {
            const std::lock_guard lock(mutex_);
            status_ = report.status;
            if (!end.complete && !stop_reason_.empty()) end.reason += ": " + stop_reason_;
            end.reason.resize(std::min(end.reason.size(), kMaxText));
            run_.reset();  // before the end is sent: the client may start another run at once
            const DeviceState state = stop_ ? DeviceState::stopped : DeviceState::failed;
            tell_health(end.complete ? DeviceState::idle : state, end.reason);
        }
        (void)stream.end(end);  // a client that is gone needs no end
    }

    /// To every client that takes data: the controller is waited for, watchers are not.
    Status send_data(const SharedMessage& message) {
        std::vector<std::shared_ptr<Connection>> takers;
        const Connection* controller = nullptr;
        {
            const std::lock_guard lock(mutex_);
            controller = controller_;
            for (const auto& client : clients_)
                if ((client->channels & kSelectData) != 0) takers.push_back(client);
        }
        Status result = controller != nullptr ? Status() : Failure{"the controlling client left"};
        for (const auto& client : takers) {
            if (client.get() == controller) {
                if (Status done = put_for_controller(*client, message); !done) result = done;
            } else if (client->outbox().put_data(message, Milliseconds(0)) == Outbox::Put::full) {
                give_up_watcher(*client);
            }
        }
        return result;
    }

    /// Waits for room in slices, because a stop must not wait while the laser is on.
    Status put_for_controller(Connection& client, const SharedMessage& message) {
        const auto begin = std::chrono::steady_clock::now();
        while (client.outbox().put_data(message, kStopSlice) == Outbox::Put::full) {
            const std::lock_guard lock(mutex_);
            if (stop_ && status_.laser_on) return Failure{"stopped on request"};
            if (std::chrono::steady_clock::now() - begin > options_.data_stall)
                return Failure{"the controlling client took no data for " +
                               std::to_string(options_.data_stall.count()) + " ms"};
        }
        return {};
    }

    /// A watcher that is too slow loses the rest of the data, and is told.
    void give_up_watcher(Connection& client) {
        const std::lock_guard lock(mutex_);
        client.channels = static_cast<std::uint8_t>(client.channels & ~kSelectData);
        Health health = health_now(DeviceState::running);
        health.message = "data ended for this watcher: it reads too slowly";
        client.send_health(health);
    }

    void take_status(const AcquireStatus& status) {
        const std::lock_guard lock(mutex_);
        const auto now = std::chrono::steady_clock::now();
        const bool changed = status.laser_on != status_.laser_on;
        status_ = status;
        if (!changed && now - last_health_ < kHealthPeriod) return;
        last_health_ = now;
        tell_health(DeviceState::running, "");
    }

    Health health_now(DeviceState state) const {
        return {device_.devices.clock.now(),
                state,
                status_.laser_on,
                device_.devices.interlock.is_closed(),
                status_.emission_s,
                status_.frames,
                status_.frames_dropped,
                ""};
    }

    void tell_health(DeviceState state, const std::string& message) {
        Health health = health_now(state);
        health.message = message;
        for (const auto& client : clients_)
            if (client->said_hello && (client->channels & kSelectHealth) != 0)
                client->send_health(health);
    }

    const ServedDevice device_;
    const ServerOptions options_;
    mutable std::mutex mutex_;  // guards all below
    std::condition_variable changed_;
    DeviceSettings settings_;
    FeatureTable features_;
    std::vector<std::shared_ptr<Connection>> clients_;  // shared with send_data, which has no lock
    Connection* controller_ = nullptr;
    std::unique_ptr<ScanPlan> run_;  // being carried out
    std::uint32_t run_number_ = 0;
    std::atomic<bool> stop_ = false;
    std::string stop_reason_;
    AcquireStatus status_;
    std::chrono::steady_clock::time_point last_health_;
    bool quitting_ = false;
    std::thread machine_;  // last: it uses all above
};

DeviceServer::DeviceServer(ServedDevice device, const ServerOptions& options)
    : state_(std::make_unique<State>(std::move(device), options)) {}
DeviceServer::~DeviceServer() = default;

void DeviceServer::serve(std::unique_ptr<ByteStream> stream) { state_->serve(std::move(stream)); }
std::size_t DeviceServer::client_count() const { return state_->client_count(); }
bool DeviceServer::is_running() const { return state_->is_running(); }

}  // namespace stria
