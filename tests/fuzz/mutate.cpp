// SPDX-License-Identifier: MIT

// Runs a fuzzer's target that makes its own inputs where the compiler has no libFuzzer: a number of chains of
// changes, always the same.

#include "random_scene.hpp"

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed);
extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace {

test::Random mutations(1);

}  // namespace

/// What libFuzzer has for its targets: here a byte that changes, or an end that is cut off.
extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t) {
    if (size == 0)
        return 0;
    if (mutations.below(8) == 0)
        return mutations.below(size);
    data[mutations.below(size)] = static_cast<std::uint8_t>(mutations.next());
    return size;
}

int main(int count, char** arguments) {
    if (count != 2) {
        std::cerr << "mutate CHAINS\n";
        return 2;
    }
    const int chains = std::atoi(arguments[1]);
    constexpr int links = 6;
    std::vector<std::uint8_t> data(65536);
    test::Random random(2);
    for (int chain = 0; chain < chains; ++chain) {
        std::size_t size = 0;
        for (int link = 0; link <= links; ++link) {
            size = LLVMFuzzerCustomMutator(data.data(), size, data.size(), random.next());
            LLVMFuzzerTestOneInput(data.data(), size);
        }
    }
    std::cout << chains * (links + 1) << " runs\n";
    return 0;
}
