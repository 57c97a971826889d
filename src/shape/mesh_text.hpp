// SPDX-License-Identifier: MIT
// What the readers of mesh files share: lines, words and numbers as people and programs write them. No locale, no
// copies; a message shows a bounded, printable piece of the file.
#pragma once

#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>

namespace dqa::mesh_text {

using std::string_view;

inline constexpr string_view kBlanks = " \t\v\f";
inline constexpr string_view kBlanksAndLineEnds = " \t\v\f\r\n";

// Without the byte-order mark of UTF-8 that some editors put first.
inline string_view without_mark(string_view text) {
    if (text.substr(0, 3) == "\xef\xbb\xbf") text.remove_prefix(3);
    return text;
}

// Without the blanks and empty lines before the first word, either.
inline string_view without_preamble(string_view text) {
    text = without_mark(text);
    const std::size_t begin = text.find_first_not_of(kBlanksAndLineEnds);
    text.remove_prefix(begin == string_view::npos ? text.size() : begin);
    return text;
}

// Lines that end in LF, CR LF or CR.
struct Lines {
    string_view rest;
    std::int64_t number = 0;  // of the line that next() gave last, from 1
    bool next(string_view& line) {
        if (rest.empty()) return false;
        std::size_t end = rest.find_first_of("\r\n");
        if (end == string_view::npos) end = rest.size();
        line = rest.substr(0, end);
        const std::size_t mark = rest.substr(end, 2) == "\r\n" ? 2 : 1;
        rest.remove_prefix(std::min(end + mark, rest.size()));
        ++number;
        return true;
    }
};

// Takes the next word off `text`; empty at the end.
inline string_view word(string_view& text, string_view separators = kBlanks) {
    const std::size_t begin = std::min(text.find_first_not_of(separators), text.size());
    text.remove_prefix(begin);
    const std::size_t end = std::min(text.find_first_of(separators), text.size());
    const string_view w = text.substr(0, end);
    text.remove_prefix(end);
    return w;
}

// Whether w is `lower`, a word in small letters, whatever the case of w.
inline bool is(string_view w, string_view lower) {
    if (w.size() != lower.size()) return false;
    for (std::size_t i = 0; i < w.size(); ++i) {
        const char c = w[i] >= 'A' && w[i] <= 'Z' ? static_cast<char>(w[i] - 'A' + 'a') : w[i];
        if (c != lower[i]) return false;
    }
    return true;
}

// A whole number; false for anything else.
inline bool parse(string_view w, std::int64_t& value) {
    if (!w.empty() && w[0] == '+') w.remove_prefix(1);
    const auto [end, error] = std::from_chars(w.data(), w.data() + w.size(), value);
    return error == std::errc() && end == w.data() + w.size();
}

// A number such as 1, +1., .73, -1e05, also nan and inf. One too small for a double is 0, one too large infinite.
inline bool parse(string_view w, double& value) {
    if (!w.empty() && w[0] == '+') w.remove_prefix(1);
    if (!w.empty() && w[0] == '+') return false;  // "++1"
    const auto [end, error] = std::from_chars(w.data(), w.data() + w.size(), value);
    if (end != w.data() + w.size()) return false;
    if (error == std::errc::result_out_of_range) {
        const std::size_t e = w.find_first_of("eE");
        const bool tiny = e != string_view::npos ? w.substr(e + 1, 1) == "-" : w.find_first_of('.') < 3;
        value = tiny ? 0.0 : std::numeric_limits<double>::infinity();
        return true;
    }
    return error == std::errc();
}

// A bounded piece of a file for a message.
inline std::string shown(string_view w) {
    std::string s(w.substr(0, 40));
    for (char& c : s)
        if (c < 32 || c > 126) c = '?';
    return w.size() > 40 ? s + "..." : s;
}

}  // namespace dqa::mesh_text
