// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/common/text.hpp"

#include <algorithm>
#include <cctype>
#include <cstdarg>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <string_view>

namespace lidar_mapping {

namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Takes the digits at the beginning of a text.
std::string_view take_digits(std::string_view& text) {
  std::size_t length = 0;
  while (length < text.size() && is_digit(text[length])) ++length;
  const std::string_view digits = text.substr(0, length);
  text.remove_prefix(length);
  return digits;
}

/// Negative, zero or positive, as std::string::compare().
int compare_numbers(std::string_view a, std::string_view b) {
  const auto without_zeros = [](std::string_view digits) {
    return digits.substr(std::min(digits.find_first_not_of('0'), digits.size()));
  };
  a = without_zeros(a);
  b = without_zeros(b);
  if (a.size() != b.size()) return a.size() < b.size() ? -1 : 1;
  return a.compare(b);
}

}  // namespace

std::string formatted(const char* format, ...) {
  va_list arguments;
  va_start(arguments, format);
  va_list again;
  va_copy(again, arguments);
  const int length = std::vsnprintf(nullptr, 0, format, arguments);
  va_end(arguments);
  std::string text(length > 0 ? static_cast<std::size_t>(length) : 0, '\0');
  // The byte after the last character of a string may be written as zero.
  if (length > 0) std::vsnprintf(text.data(), text.size() + 1, format, again);
  va_end(again);
  return text;
}

std::string joined(const std::vector<std::string>& parts, const std::string& separator) {
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : separator) + part;
  return text;
}

std::string counted(std::size_t count, const std::string& noun) {
  return std::to_string(count) + ' ' + noun + (count == 1 ? "" : "s");
}

bool contains(const std::vector<std::string>& texts, const std::string& text) {
  return std::find(texts.begin(), texts.end(), text) != texts.end();
}

std::string lower_case(std::string text) {
  for (char& letter : text) {
    letter = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
  }
  return text;
}

bool in_order_of_numbers(const std::string& a, const std::string& b) {
  std::string_view rest_a = a, rest_b = b;
  bool behind_number = false, behind_point = false;
  while (!rest_a.empty() && !rest_b.empty()) {
    if (is_digit(rest_a.front()) && is_digit(rest_b.front())) {
      const std::string_view digits_a = take_digits(rest_a), digits_b = take_digits(rest_b);
      const int order =
          behind_point ? digits_a.compare(digits_b) : compare_numbers(digits_a, digits_b);
      if (order != 0) return order < 0;
      behind_number = true;
      behind_point = false;
      continue;
    }
    if (rest_a.front() != rest_b.front()) return rest_a.front() < rest_b.front();
    behind_point = behind_number && rest_a.front() == '.';
    behind_number = false;
    rest_a.remove_prefix(1);
    rest_b.remove_prefix(1);
  }
  if (rest_a.empty() != rest_b.empty()) return rest_a.empty();
  return a < b;  // 01 and 1
}

std::string quoted(const std::string& text, char mark) {
  std::string result(1, mark);
  for (const char letter : text) {
    if (letter == mark) result += mark;
    result += letter;
  }
  return result + mark;
}

std::string seconds_text(Stamp stamp) {
  const Stamp magnitude = std::abs(stamp);
  return formatted("%s%lld.%09lld", stamp < 0 ? "-" : "",
                   static_cast<long long>(magnitude / kNanosecondsPerSecond),
                   static_cast<long long>(magnitude % kNanosecondsPerSecond));
}

}  // namespace lidar_mapping
