// SPDX-License-Identifier: MIT

// What the host has found for pixels (host_rows.hpp). Whoever includes this defines HOST_ROWS_BINDING, the first of two.

// Of each pixel one more than its row of the host's answers; 0: none.
layout(std430, set = 1, binding = HOST_ROWS_BINDING) readonly buffer AnswerRows {
    uint answer_rows[];
};
// Rows of S of all lights.
layout(std430, set = 1, binding = HOST_ROWS_BINDING + 1) readonly buffer Answers {
    float answers[];
};

float answer_in(uint row, uint light) {
    return answers[(row - 1u) * frame.numbers.x + light];
}
