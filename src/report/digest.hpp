// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <sstream>
#include <string>

namespace lidar_mapping::report {

/// FNV-1a with 64 bits: enough to distinguish recordings and maps, as no forgery is expected.
class Digest {
 public:
  void add(const std::string& bytes) {
    for (const char byte : bytes) {
      value_ ^= static_cast<unsigned char>(byte);
      value_ *= 0x100000001B3U;
    }
  }
  std::string text() const {
    std::ostringstream stream;
    stream << std::hex << value_;
    return stream.str();
  }

 private:
  std::uint64_t value_ = 0xCBF29CE484222325U;
};

}  // namespace lidar_mapping::report
