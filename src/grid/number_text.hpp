// SPDX-License-Identifier: MIT
// Numbers in messages: the fewest digits that tell a number from every other one, so that 1.00000012 does not read 1.
#pragma once

#include <charconv>
#include <cmath>
#include <string>

namespace dqa {

inline std::string number_text(double x) {
    if (std::isnan(x)) return "nan";  // whatever its sign bit
    char text[32];
    const auto end = std::to_chars(text, text + sizeof text, x).ptr;
    return std::string(text, end);
}

}  // namespace dqa
