// SPDX-License-Identifier: MIT
#include "render/share_out.hpp"

#include "render/runs.hpp"
#include "render/terminal.hpp"

#include <condition_variable>
#include <cstdint>
#include <cstring>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

namespace demo {

namespace {

using namespace std::chrono_literals;

constexpr std::uint64_t no_item = ~std::uint64_t{0};

/// A number behind bytes.
Bytes with_number(Bytes bytes, std::uint64_t number) {
    const std::size_t size = bytes.size();
    bytes.resize(size + sizeof number);
    std::memcpy(bytes.data() + size, &number, sizeof number);
    return bytes;
}

std::uint64_t take_number(Bytes& bytes) {
    std::uint64_t number = no_item;
    if (bytes.size() < sizeof number)
        throw std::runtime_error("a message of another rank is too short");
    const std::size_t size = bytes.size() - sizeof number;
    std::memcpy(&number, bytes.data() + size, sizeof number);
    bytes.resize(size);
    return number;
}

/// Throws what has put an end to work.
void throw_end(Ranks& ranks) {
    ranks.check_others();
    throw Interrupted("it was told to end");
}

/// The parts that rank 0 has to hand out, and a thread that hands it out to the others.
class Desk {
public:
    Desk(Ranks& ranks, int tag, std::size_t count, const TakeResult& take)
        : ranks_(ranks), tag_(tag), runs_(count, ranks.size()), left_(count), take_(take),
          thread_([this] { serve(); }) {}
    ~Desk() {
        is_over_ = true;
        if (thread_.joinable())
            thread_.join();
    }
    Desk(const Desk&) = delete;
    Desk& operator=(const Desk&) = delete;

    const std::atomic<bool>& is_over() const { return is_over_; }

    std::optional<std::size_t> next() { return next(0); }
    void take(std::size_t item, Bytes result) { take(item, 0, std::move(result)); }

    /// Waits until all is taken; throws what the thread has met.
    void finish() {
        thread_.join();
        if (failure_)
            std::rethrow_exception(failure_);
    }

private:
    std::optional<std::size_t> next(int rank) {
        const std::scoped_lock lock(guard_);
        return runs_.next(rank);
    }

    void take(std::size_t item, int rank, Bytes result) {
        const std::scoped_lock lock(guard_);
        take_(item, rank, std::move(result));
        --left_;
    }

    bool is_all_taken() {
        const std::scoped_lock lock(guard_);
        return left_ == 0;
    }

    void serve() {
        try {
            for (int at_work = ranks_.size() - 1; at_work > 0 || !is_all_taken();) {
                if (is_over_)
                    return;
                std::optional<RankMessage> message = ranks_.poll(tag_);
                if (!message) {
                    ranks_.check_others();
                    std::this_thread::sleep_for(200us);
                    continue;
                }
                if (const std::uint64_t item = take_number(message->bytes); item != no_item)
                    take(item, message->from, std::move(message->bytes));
                const std::optional<std::size_t> item = next(message->from);
                at_work -= item ? 0 : 1;
                ranks_.send(message->from, tag_, with_number({}, item ? *item : no_item));
            }
        } catch (...) {
            failure_ = std::current_exception();
            is_over_ = true;
        }
    }

    Ranks& ranks_;
    int tag_;
    std::mutex guard_;
    Runs runs_;
    std::size_t left_;
    const TakeResult& take_;
    std::exception_ptr failure_;
    std::atomic<bool> is_over_{false};
    std::thread thread_;
};

void work_at_desk(Ranks& ranks, int tag, std::size_t count, const Work& work, const TakeResult& take) {
    Desk desk(ranks, tag, count, take);
    while (const std::optional<std::size_t> item = desk.is_over() ? std::nullopt : desk.next()) {
        WorkWatch watch(ranks, &desk.is_over());
        Bytes result = work(*item, watch);
        if (watch.is_in_vain())
            break;
        desk.take(*item, std::move(result));
    }
    desk.finish();
}

void work_for_desk(Ranks& ranks, int tag, const Work& work) {
    Bytes result;
    for (std::uint64_t item = no_item;;) {
        ranks.send(0, tag, with_number(std::move(result), item));
        Bytes reply = ranks.receive(0, tag);
        item = take_number(reply);
        if (item == no_item)
            return;
        WorkWatch watch(ranks);
        result = work(item, watch);
        if (watch.is_in_vain())
            throw_end(ranks);
    }
}

void work_alone(Ranks& ranks, std::size_t count, const Work& work, const TakeResult& take) {
    for (std::size_t item = 0; item < count; ++item) {
        WorkWatch watch(ranks);
        Bytes result = work(item, watch);
        if (watch.is_in_vain())
            throw_end(ranks);
        take(item, 0, std::move(result));
    }
}

}  // namespace

void WorkWatch::look() {
    if (interrupted() || (is_over_ != nullptr && *is_over_))
        is_in_vain_ = true;
    const auto now = std::chrono::steady_clock::now();
    if (now - looked_ < 20ms)
        return;
    looked_ = now;
    if (ranks_.is_stopped())
        is_in_vain_ = true;
}

void WorkWatch::look_during(const std::function<void()>& work) {
    look();
    std::mutex guard;
    std::condition_variable changed;
    bool is_done = false;
    std::exception_ptr failure;
    std::thread thread([&] {
        std::unique_lock lock(guard);
        try {
            while (!changed.wait_for(lock, 20ms, [&] { return is_done; }))
                look();
        } catch (...) {
            failure = std::current_exception();
            is_in_vain_ = true;
        }
    });
    const auto end_thread = [&] {
        {
            const std::scoped_lock lock(guard);
            is_done = true;
        }
        changed.notify_one();
        thread.join();
    };
    try {
        work();
    } catch (...) {
        end_thread();
        throw;
    }
    end_thread();
    if (failure)
        std::rethrow_exception(failure);
}

void share_out(Ranks& ranks, std::size_t count, const Work& work, const TakeResult& take) {
    if (ranks.size() == 1)
        return work_alone(ranks, count, work, take);
    // A rank may ask for the next things while another one is still at these.
    static int calls = 0;
    const int tag = calls++ % 1024;
    if (ranks.is_first())
        work_at_desk(ranks, tag, count, work, take);
    else
        work_for_desk(ranks, tag, work);
}

}  // namespace demo
