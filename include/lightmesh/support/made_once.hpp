// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <memory>
#include <type_traits>
#include <utility>

namespace lightmesh::detail {

/// A T, or an array of T for T[], that is made when somebody first needs it and does not change then. Any
/// number of threads may look; who makes it holds a lock of the owner's meanwhile.
template <class T>
class MadeOnce {
public:
    using Element = std::remove_extent_t<T>;

    /// Null as long as it is not made.
    const Element* get() const { return made_.load(std::memory_order_acquire); }

    /// By one thread at a time, once.
    void publish(std::unique_ptr<T> whole) {
        owner_ = std::move(whole);
        made_.store(owner_.get(), std::memory_order_release);
    }

    /// What was made; it is not there any more then. Nobody may look meanwhile.
    std::unique_ptr<T> take() {
        made_.store(nullptr, std::memory_order_relaxed);
        return std::move(owner_);
    }

    /// As if it was never made. Nobody may look meanwhile.
    void forget() {
        made_.store(nullptr, std::memory_order_relaxed);
        owner_.reset();
    }

private:
    std::unique_ptr<T> owner_;
    std::atomic<const Element*> made_{nullptr};
};

}  // namespace lightmesh::detail
