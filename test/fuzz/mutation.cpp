// SPDX-License-Identifier: BSD-3-Clause
#include "mutation.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <functional>
#include <vector>

namespace lidar_mapping::test {

namespace {

constexpr std::size_t kLongestPart = 200;  // bytes that are cut, repeated or moved at a time

class Mutator {
 public:
  Mutator(std::string bytes, std::mt19937& engine) : bytes_(std::move(bytes)), engine_(engine) {}

  std::string run() {
    using Step = void (Mutator::*)();
    static constexpr std::array<Step, 12> kSteps = {
        &Mutator::flip_bit,  &Mutator::overwrite,   &Mutator::put_odd_number,
        &Mutator::cut_out,   &Mutator::repeat,      &Mutator::move,
        &Mutator::insert,    &Mutator::cut_off,     &Mutator::swap_lines,
        &Mutator::lose_line, &Mutator::repeat_line, &Mutator::replace_number};
    const std::size_t steps = 1 + below(6);
    for (std::size_t i = 0; i < steps; ++i) (this->*kSteps[below(kSteps.size())])();
    return std::move(bytes_);
  }

 private:
  std::size_t below(std::size_t limit) { return limit == 0 ? 0 : engine_() % limit; }
  /// Damage of the beginning, where headers are, is as likely as that of the rest.
  std::size_t place() {
    constexpr std::size_t kBeginning = 500;
    const bool at_beginning = below(2) == 0;
    return below(at_beginning ? std::min(kBeginning, bytes_.size()) : bytes_.size());
  }
  std::size_t length() { return 1 + below(below(3) == 0 ? kLongestPart : 8); }

  void flip_bit() {
    if (bytes_.empty()) return;
    char& byte = bytes_[place()];
    byte = static_cast<char>(byte ^ (1 << below(8)));
  }
  void overwrite() {
    const std::size_t at = place(), end = std::min(bytes_.size(), at + length());
    for (std::size_t i = at; i < end; ++i) bytes_[i] = static_cast<char>(engine_());
  }
  /// Of four bytes, as lengths and counts are.
  void put_odd_number() {
    static constexpr std::array<std::uint32_t, 8> kOdd = {
        0, 1, 0x7F, 0xFF, 0xFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF};
    const std::uint32_t number = kOdd[below(kOdd.size())];
    const std::size_t at = place();
    for (std::size_t i = 0; i < 4 && at + i < bytes_.size(); ++i) {
      bytes_[at + i] = static_cast<char>(number >> (8 * i));
    }
  }
  void cut_out() { bytes_.erase(std::min(place(), bytes_.size()), length()); }
  void repeat() {
    const std::size_t at = place();
    const std::string part = bytes_.substr(std::min(at, bytes_.size()), length());
    const std::size_t times = 1 + below(below(4) == 0 ? 300 : 3);
    std::string more;
    for (std::size_t i = 0; i < times; ++i) more += part;
    bytes_.insert(std::min(at, bytes_.size()), more);
  }
  void move() {
    const std::size_t from = std::min(place(), bytes_.size());
    const std::string part = bytes_.substr(from, length());
    bytes_.erase(from, part.size());
    bytes_.insert(std::min(place(), bytes_.size()), part);
  }
  void insert() {
    static const std::vector<std::string> kWords = {"[",
                                                    "]",
                                                    "{",
                                                    "}",
                                                    ": ",
                                                    "- ",
                                                    "? ",
                                                    "&a [*a]",
                                                    "*a",
                                                    "!!",
                                                    "| ",
                                                    "%",
                                                    "\"",
                                                    "'",
                                                    "\t",
                                                    "#",
                                                    "\n",
                                                    "\r\n",
                                                    "nan",
                                                    "-",
                                                    "=",
                                                    ",",
                                                    std::string(1, '\0'),
                                                    "\xFF\xFE"};
    bytes_.insert(std::min(place(), bytes_.size()), kWords[below(kWords.size())]);
  }
  void cut_off() {
    if (below(3) == 0) bytes_.resize(below(bytes_.size() + 1));
  }

  /// Where the line at a random place begins, and how long it is with its end.
  std::pair<std::size_t, std::size_t> line() {
    if (bytes_.empty()) return {0, 0};
    const std::size_t at = place();
    const std::size_t before = at == 0 ? std::string::npos : bytes_.rfind('\n', at - 1);
    const std::size_t begin = before == std::string::npos ? 0 : before + 1;
    const std::size_t end = std::min(bytes_.find('\n', begin), bytes_.size() - 1) + 1;
    return {begin, end - begin};
  }
  void swap_lines() {
    const auto [a, a_length] = line();
    const std::string text = bytes_.substr(a, a_length);
    bytes_.erase(a, a_length);
    const auto [b, b_length] = line();
    bytes_.insert(b, text);
  }
  void lose_line() {
    const auto [begin, size] = line();
    bytes_.erase(begin, size);
  }
  void repeat_line() {
    const auto [begin, size] = line();
    bytes_.insert(begin, bytes_.substr(begin, size));
  }
  /// The digits at or behind a random place give way to another number.
  void replace_number() {
    static const std::vector<std::string> kNumbers = {
        "nan",        "inf",   "-inf",    "-1",
        "0",          "1e308", "-1e-308", "99999999999999999999",
        "4294967296", "0x10",  "1e9",     "",
        "2147483648", "1.2.3"};
    const auto is_digit = [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; };
    const auto from =
        std::find_if(bytes_.begin() + static_cast<std::ptrdiff_t>(std::min(place(), bytes_.size())),
                     bytes_.end(), is_digit);
    const auto until = std::find_if_not(from, bytes_.end(), is_digit);
    bytes_.replace(from, until, kNumbers[below(kNumbers.size())]);
  }

  std::string bytes_;
  std::mt19937& engine_;
};

}  // namespace

std::string mutated(std::string bytes, std::mt19937& engine) {
  return Mutator(std::move(bytes), engine).run();
}

}  // namespace lidar_mapping::test
