// SPDX-License-Identifier: MIT
#pragma once

#include "render/terminal.hpp"

#include <cstddef>
#include <cstring>
#include <exception>
#include <functional>
#include <list>
#include <mutex>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace demo {

using Bytes = std::vector<std::byte>;

/// A value without pointers, for ranks that run the same program.
template <class Value>
Bytes bytes_of(const Value& value) {
    static_assert(std::is_trivially_copyable_v<Value>);
    Bytes bytes(sizeof value);
    std::memcpy(bytes.data(), &value, sizeof value);
    return bytes;
}
/// Throws std::runtime_error if it is not what `bytes_of` has made of such a value.
template <class Value>
Value value_in(const Bytes& bytes) {
    static_assert(std::is_trivially_copyable_v<Value>);
    if (bytes.size() != sizeof(Value))
        throw std::runtime_error("another rank has sent " + std::to_string(bytes.size()) + " bytes, not " +
                                 std::to_string(sizeof(Value)) + ": it runs another program");
    Value value;
    std::memcpy(&value, bytes.data(), sizeof value);
    return value;
}

/// Text as bytes, and back.
inline Bytes bytes_of_text(const std::string& text) {
    const std::span<const std::byte> bytes = std::as_bytes(std::span(text));
    return {bytes.begin(), bytes.end()};
}
inline std::string text_in(const Bytes& bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Bytes that a rank has sent.
struct RankMessage {
    int from;
    Bytes bytes;
};

/// On ranks but the first: it has told them to stop, and says itself why.
class Stopped : public std::exception {
public:
    const char* what() const noexcept override { return "stopped by rank 0"; }
};

/// The program was told to end by Ctrl-C or SIGTERM, this process or that of another rank.
class Interrupted : public std::runtime_error {
public:
    using runtime_error::runtime_error;
};

/// The processes that work on the same thing, each with its number, its rank: those that mpirun has started,
/// or this process alone. There is at most one object of this class. Its members may be used by several
/// threads, as long as no two of them wait for messages of the same tag.
///
/// Whoever waits, waits for all: if another rank has failed, rank 0 throws std::runtime_error that names it
/// and its reason, and the others `Stopped`; if the program was told to end, both throw `Interrupted`.
/// Waiting takes next to no processor time.
class Ranks {
public:
    /// Finds the other processes. If there are some and this program was built without MPI, rank 0 throws
    /// std::runtime_error, the others `Stopped`.
    Ranks();
    /// Rank 0 ends all: waits until they have left what they were at.
    ~Ranks();
    Ranks(const Ranks&) = delete;
    Ranks& operator=(const Ranks&) = delete;

    int rank() const { return rank_; }
    int size() const { return size_; }
    bool is_first() const { return rank_ == 0; }

    /// Messages of one sender and one tag arrive in the order in which they were sent. A tag is in [0,
    /// 16384).
    void send(int to, int tag, Bytes bytes);
    Bytes receive(int from, int tag);
    /// A message of any rank, if there is one.
    std::optional<RankMessage> poll(int tag);
    /// Throws what waiting would throw.
    void check_others();
    /// On ranks but the first: whether rank 0 has told them to stop. On the first: false.
    bool is_stopped();

    /// On rank 0: what each rank gives, in their order. Elsewhere: nothing.
    std::vector<Bytes> gather(Bytes mine);
    /// Rank 0's bytes, everywhere.
    Bytes broadcast(Bytes mine);

    /// Lets rank 0 know that this rank has failed, and why.
    void tell_failure(const std::string& why, bool is_interrupted) noexcept;

private:
    void wait_until(const std::function<bool()>& done);
    void tell_all_to_stop() noexcept;
    void end_others();

    int rank_ = 0;
    int size_ = 1;
    bool is_stopped_ = false;
    std::mutex calls_;         // of MPI, one at a time
    std::list<Bytes> unsent_;  // MPI may read them until it ends
};

/// Programs that mpirun has started have no terminal: rank 0 shows progress in lines.
ProgressBar::Elsewhere progress_elsewhere(const Ranks& ranks);

/// Throws std::invalid_argument if there are other ranks: `command` is for one.
void require_one_rank(const Ranks& ranks, const std::string& command);

}  // namespace demo
