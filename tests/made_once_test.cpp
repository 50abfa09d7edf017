// SPDX-License-Identifier: MIT
#include <lightmesh/support/made_once.hpp>

#include <doctest/doctest.h>

#include <cstddef>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace made_once_test {

using lightmesh::detail::MadeOnce;

TEST_CASE("what is made once is whole for all threads that see it") {
    MadeOnce<int[]> numbers;
    std::mutex making;
    int made = 0;
    CHECK(numbers.get() == nullptr);
    const auto look = [&](int& sum) {
        if (numbers.get() == nullptr) {
            const std::scoped_lock lock(making);
            if (numbers.get() == nullptr) {
                auto whole = std::make_unique<int[]>(1000);
                for (std::size_t i = 0; i < 1000; ++i)
                    whole[i] = 1;
                ++made;
                numbers.publish(std::move(whole));
            }
        }
        for (std::size_t i = 0; i < 1000; ++i)
            sum += numbers.get()[i];
    };
    std::vector<int> sums(4, 0);
    std::vector<std::thread> threads;
    for (int& sum : sums)
        threads.emplace_back([&] { look(sum); });
    for (std::thread& thread : threads)
        thread.join();
    CHECK(sums == std::vector<int>(4, 1000));
    CHECK(made == 1);
}

}  // namespace made_once_test
