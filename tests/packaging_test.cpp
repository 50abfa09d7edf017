// SPDX-License-Identifier: MIT
#include "blank_adapters.hpp"

#include <doctest/doctest.h>

float sum_in_another_file();       // odr.cpp
float sum_under_hostile_macros();  // hostile_macros.cpp

TEST_CASE("several files of a program use the library") {
    CHECK(test::sum_of_meshes() == 30.0f);
    CHECK(test::all_else_is_open());
    CHECK(sum_in_another_file() == 30.0f);
}

TEST_CASE("headers that leave macros behind do no harm") {
    CHECK(sum_under_hostile_macros() == 30.0f);
}
