#include <string>

#include <gtest/gtest.h>

#include "xxh32.hpp"

namespace lidar_mapping::ros_border {
namespace {

std::uint32_t hash_of(const std::string& text) {
  return xxh32({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

TEST(Xxh32, GivesWhatIsPublished) {
  EXPECT_EQ(hash_of(""), 0x02CC5D05U);
  EXPECT_EQ(hash_of("a"), 0x550D7456U);
  EXPECT_EQ(hash_of("abc"), 0x32D153FFU);
  EXPECT_EQ(hash_of("Nobody inspects the spammish repetition"), 0xE2293B2FU);
}

// By another implementation of the specification.
TEST(Xxh32, GoesThroughManyBlocks) {
  std::string text;
  for (int i = 0; i < 1000; ++i) text += static_cast<char>('a' + i % 26);
  EXPECT_EQ(hash_of(text), 0x6D9C405DU);
  EXPECT_EQ(hash_of(text.substr(0, 240)), 0xC47697A6U);
}

}  // namespace
}  // namespace lidar_mapping::ros_border
