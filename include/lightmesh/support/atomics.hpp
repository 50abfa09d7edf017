// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstdint>
#include <thread>

/// Plain integers that several threads share. They stay plain so that what holds them can be copied, saved
/// and read in target, byte by byte.

namespace lightmesh::detail {

template <class T>
T load_relaxed(const T& value) {
    return std::atomic_ref<T>(const_cast<T&>(value)).load(std::memory_order_relaxed);
}

/// Sees all that was written before the `store_release` whose value it reads.
template <class T>
T load_acquire(const T& value) {
    return std::atomic_ref<T>(const_cast<T&>(value)).load(std::memory_order_acquire);
}

template <class T>
void store_relaxed(T& target, T value) {
    std::atomic_ref<T>(target).store(value, std::memory_order_relaxed);
}

template <class T>
void store_release(T& target, T value) {
    std::atomic_ref<T>(target).store(value, std::memory_order_release);
}

template <class T>
void or_relaxed(T& target, T bits) {
    std::atomic_ref<T>(target).fetch_or(bits, std::memory_order_relaxed);
}

template <class T>
void or_release(T& target, T bits) {
    std::atomic_ref<T>(target).fetch_or(bits, std::memory_order_release);
}

/// Holds a lock that is a plain integer, 0 while it is free. For work of some hundred nanoseconds.
class SpinLock {
public:
    explicit SpinLock(std::uint8_t& target) : target_(target) {
        while (target_.exchange(1, std::memory_order_acquire) != 0)
            std::this_thread::yield();
    }
    ~SpinLock() { target_.store(0, std::memory_order_release); }
    SpinLock(const SpinLock&) = delete;
    SpinLock& operator=(const SpinLock&) = delete;

private:
    std::atomic_ref<std::uint8_t> target_;
};

}  // namespace lightmesh::detail
