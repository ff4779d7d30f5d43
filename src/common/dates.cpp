// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/common/dates.hpp"

#include <array>
#include <ctime>

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping {

namespace {

/// A way to write a date, and how long what it names lasts, s.
struct DateFormat {
  const char* format;
  Stamp seconds;
};
constexpr std::array<DateFormat, 3> kFormats = {
    {{"%Y-%m-%d", 24 * 3600}, {"%Y-%m-%dT%H:%M", 60}, {"%Y-%m-%dT%H:%M:%S", 1}}};

bool is_end(const char* rest) { return *rest == '\0' || std::string(rest) == "Z"; }

}  // namespace

std::string iso_date(Stamp stamp) {
  const auto seconds = static_cast<std::time_t>(stamp / kNanosecondsPerSecond);
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  std::array<char, 40> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text.data();
}

std::string dated_name(std::time_t time) {
  std::tm parts{};
  localtime_r(&time, &parts);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%d_%H-%M-%S", &parts);
  return text.data();
}

Stamp end_of_date(const std::string& text) {
  for (const DateFormat& known : kFormats) {
    std::tm parts{};
    const char* rest = strptime(text.c_str(), known.format, &parts);
    if (rest == nullptr || !is_end(rest)) continue;
    const int day = parts.tm_mday;
    const auto begin = static_cast<Stamp>(timegm(&parts));
    if (parts.tm_mday != day) break;  // 31 April became 1 May
    return (begin + known.seconds) * kNanosecondsPerSecond - 1;
  }
  throw InputError("'" + text +
                   "' is not a date; write it as 2026-05-01 or 2026-05-01T12:00 (UTC)");
}

}  // namespace lidar_mapping
