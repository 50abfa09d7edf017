// SPDX-License-Identifier: MIT
#include "render/ranks.hpp"

#ifdef LIGHTMESH_WITH_MPI
#include <mpi.h>
#endif

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <initializer_list>
#include <thread>
#include <utility>

namespace demo {

namespace {

// Behind those of users.
constexpr int tag_gather = 16384;
constexpr int tag_broadcast = 16385;
constexpr int tag_failure = 16386;  ///< to rank 0: a byte that is 1 if the rank was interrupted, then why
constexpr int tag_stop = 16387;     ///< from rank 0
constexpr int tag_end = 16388;      ///< to rank 0, the last message

/// A piece that is shorter than this ends a message: MPI counts in int.
constexpr std::size_t piece_size = std::size_t{1} << 26;
/// The time that rank 0 waits at the end for ranks that are still at something.
constexpr std::chrono::seconds patience{60};

/// The names under which launchers tell a process its rank.
const char* told_by_launcher(std::initializer_list<const char*> names) {
    for (const char* name : names)
        if (const char* value = std::getenv(name))
            return value;
    return nullptr;
}

/// Soon at first, then ever more rarely, up to once in a millisecond.
class Pause {
public:
    void operator()() {
        std::this_thread::sleep_for(std::chrono::microseconds(microseconds_));
        microseconds_ = (std::min)(2 * microseconds_, 1000);
    }

private:
    int microseconds_ = 10;
};

}  // namespace

#ifdef LIGHTMESH_WITH_MPI

namespace {

void check(int result, const char* what) {
    if (result == MPI_SUCCESS)
        return;
    char text[MPI_MAX_ERROR_STRING] = "";
    int length = 0;
    MPI_Error_string(result, text, &length);
    throw std::runtime_error(std::string("MPI could not ") + what + ": " + text);
}

/// A message that has arrived, or its first piece, from a rank or MPI_ANY_SOURCE. `calls` must be held.
std::optional<RankMessage> arrived(int from, int tag) {
    int is_there = 0;
    MPI_Message message{};
    MPI_Status status{};
    check(MPI_Improbe(from, tag, MPI_COMM_WORLD, &is_there, &message, &status), "look for a message");
    if (is_there == 0)
        return std::nullopt;
    int count = 0;
    check(MPI_Get_count(&status, MPI_BYTE, &count), "receive a message");
    RankMessage piece{status.MPI_SOURCE, Bytes(static_cast<std::size_t>(count))};
    check(MPI_Mrecv(piece.bytes.data(), count, MPI_BYTE, &message, &status), "receive a message");
    return piece;
}

bool is_whole(const RankMessage& piece) {
    return piece.bytes.size() < piece_size;
}

}  // namespace

Ranks::Ranks() {
    if (told_by_launcher({"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK"}) == nullptr)
        return;
    int provided = 0;
    check(MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &provided), "begin");
    MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_RETURN);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &size_);
    if (provided < MPI_THREAD_SERIALIZED && size_ > 1)
        throw std::runtime_error("this MPI does not let threads call it");
}

Ranks::~Ranks() {
    int is_begun = 0;
    MPI_Initialized(&is_begun);
    if (is_begun == 0)
        return;
    try {
        if (size_ > 1)
            end_others();
    } catch (const std::exception& error) {
        std::fprintf(stderr, "lightmesh-render: %s\n", error.what());
        MPI_Abort(MPI_COMM_WORLD, 1);
    }
    MPI_Finalize();
}

/// Ranks wait here for each other without taking processor time, as they would in MPI_Finalize.
void Ranks::end_others() {
    const auto until = std::chrono::steady_clock::now() + patience;
    Pause pause;
    const auto wait = [&](const auto& done, bool for_ever) {
        while (!done()) {
            if (!for_ever && std::chrono::steady_clock::now() > until)
                return false;
            pause();
        }
        return true;
    };
    if (!is_first()) {
        wait([&] { return is_stopped(); }, true);
        const std::scoped_lock lock(calls_);
        MPI_Send(nullptr, 0, MPI_BYTE, 0, tag_end, MPI_COMM_WORLD);
        return;
    }
    tell_all_to_stop();
    for (int other = 1; other < size_; ++other)
        if (!wait([&] { return arrived(other, tag_end).has_value(); }, false)) {
            std::fprintf(stderr, "lightmesh-render: rank %d does not answer: all are ended\n", other);
            MPI_Abort(MPI_COMM_WORLD, 1);
        }
}

void Ranks::send(int to, int tag, Bytes bytes) {
    const auto message = [&] {
        const std::scoped_lock lock(calls_);
        return unsent_.insert(unsent_.end(), std::move(bytes));
    }();
    std::size_t sent = 0;
    bool is_last = false;
    while (!is_last) {
        const std::size_t size = (std::min)(piece_size, message->size() - sent);
        MPI_Request request{};
        {
            const std::scoped_lock lock(calls_);
            check(MPI_Isend(message->data() + sent, static_cast<int>(size), MPI_BYTE, to, tag, MPI_COMM_WORLD,
                            &request),
                  "send");
        }
        wait_until([&] {
            int is_sent = 0;
            const std::scoped_lock lock(calls_);
            check(MPI_Test(&request, &is_sent, MPI_STATUS_IGNORE), "send");
            return is_sent != 0;
        });
        sent += size;
        is_last = size < piece_size;
    }
    const std::scoped_lock lock(calls_);
    unsent_.erase(message);
}

Bytes Ranks::receive(int from, int tag) {
    Bytes all;
    bool is_last = false;
    while (!is_last) {
        std::optional<RankMessage> piece;
        wait_until([&] {
            const std::scoped_lock lock(calls_);
            piece = arrived(from, tag);
            return piece.has_value();
        });
        is_last = is_whole(*piece);
        if (all.empty())
            all = std::move(piece->bytes);
        else
            all.insert(all.end(), piece->bytes.begin(), piece->bytes.end());
    }
    return all;
}

std::optional<RankMessage> Ranks::poll(int tag) {
    std::optional<RankMessage> message;
    {
        const std::scoped_lock lock(calls_);
        message = arrived(MPI_ANY_SOURCE, tag);
    }
    if (message && !is_whole(*message)) {
        const Bytes rest = receive(message->from, tag);
        message->bytes.insert(message->bytes.end(), rest.begin(), rest.end());
    }
    return message;
}

bool Ranks::is_stopped() {
    if (size_ == 1 || is_first())
        return false;
    const std::scoped_lock lock(calls_);
    is_stopped_ = is_stopped_ || arrived(0, tag_stop).has_value();
    return is_stopped_;
}

void Ranks::check_others() {
    if (size_ > 1 && is_first()) {
        std::optional<RankMessage> failure;
        {
            const std::scoped_lock lock(calls_);
            failure = arrived(MPI_ANY_SOURCE, tag_failure);
        }
        if (failure && !failure->bytes.empty()) {
            const auto* text = reinterpret_cast<const char*>(failure->bytes.data());
            const std::string why = "rank " + std::to_string(failure->from) + " of " + std::to_string(size_) +
                                    ": " + std::string(text + 1, failure->bytes.size() - 1);
            if (text[0] != 0)
                throw Interrupted(why);
            throw std::runtime_error(why);
        }
    }
    if (is_stopped())
        throw Stopped();
    if (interrupted())
        throw Interrupted("it was told to end");
}

void Ranks::tell_failure(const std::string& why, bool is_interrupted) noexcept {
    if (size_ == 1 || is_first())
        return;
    const std::string text = (is_interrupted ? '\1' : '\0') + why;
    const std::scoped_lock lock(calls_);
    MPI_Send(text.data(), static_cast<int>((std::min)(text.size(), std::size_t{2000})), MPI_BYTE, 0,
             tag_failure, MPI_COMM_WORLD);
}

void Ranks::tell_all_to_stop() noexcept {
    const std::scoped_lock lock(calls_);
    for (int other = 1; other < size_; ++other)
        MPI_Send(nullptr, 0, MPI_BYTE, other, tag_stop, MPI_COMM_WORLD);
}

#else

Ranks::Ranks() {
    const char* size = told_by_launcher({"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"});
    if (size == nullptr || std::atoi(size) <= 1)
        return;
    const char* rank = told_by_launcher({"OMPI_COMM_WORLD_RANK", "PMI_RANK"});
    if (rank != nullptr && std::atoi(rank) > 0)
        throw Stopped();
    throw std::runtime_error(std::string("it was started ") + size +
                             " times, but built without MPI (Debian: apt-get install libopenmpi-dev)");
}

Ranks::~Ranks() = default;

void Ranks::send(int /*to*/, int /*tag*/, Bytes /*bytes*/) {}
Bytes Ranks::receive(int /*from*/, int /*tag*/) {
    return {};
}
std::optional<RankMessage> Ranks::poll(int /*tag*/) {
    return std::nullopt;
}
void Ranks::check_others() {
    if (interrupted())
        throw Interrupted("it was told to end");
}
bool Ranks::is_stopped() {
    return false;
}
void Ranks::tell_failure(const std::string& /*why*/, bool /*is_interrupted*/) noexcept {}

#endif

void Ranks::wait_until(const std::function<bool()>& done) {
    Pause pause;
    while (!done()) {
        check_others();
        pause();
    }
}

std::vector<Bytes> Ranks::gather(Bytes mine) {
    if (!is_first()) {
        send(0, tag_gather, std::move(mine));
        return {};
    }
    std::vector<Bytes> all{std::move(mine)};
    for (int other = 1; other < size_; ++other)
        all.push_back(receive(other, tag_gather));
    return all;
}

/// Along a tree: whoever has them passes them on, to half of the ranks that are left, then to a quarter.
Bytes Ranks::broadcast(Bytes mine) {
    int step = 1;
    while (step < size_ && rank_ % (2 * step) == 0)
        step *= 2;
    if (!is_first())
        mine = receive(rank_ - step, tag_broadcast);
    for (step /= 2; step > 0; step /= 2)
        if (rank_ + step < size_)
            send(rank_ + step, tag_broadcast, mine);
    return mine;
}

ProgressBar::Elsewhere progress_elsewhere(const Ranks& ranks) {
    return ranks.size() > 1 && ranks.is_first() ? ProgressBar::Elsewhere::lines
                                                : ProgressBar::Elsewhere::nothing;
}

void require_one_rank(const Ranks& ranks, const std::string& command) {
    if (ranks.size() > 1)
        throw std::invalid_argument(command + " runs in one process, not in " + std::to_string(ranks.size()) +
                                    "; film and picture share their work out");
}

}  // namespace demo
