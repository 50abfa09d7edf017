// SPDX-License-Identifier: MIT
#pragma once

namespace bench {

/// Adds machine, compiler, flags and libraries to what Google Benchmark writes into its reports.
void describe_context();

}  // namespace bench
