// SPDX-License-Identifier: MIT
#include "context.hpp"

#include "render/machine.hpp"
#include "workloads.hpp"

#include <benchmark/benchmark.h>

#include <string>

namespace bench {

void describe_context() {
    for (const auto& [name, value] : demo::describe_machine())
        benchmark::AddCustomContext(name, value);
    benchmark::AddCustomContext("picture",
                                std::to_string(picture_width) + "x" + std::to_string(picture_height));
}

}  // namespace bench
