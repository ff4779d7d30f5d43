// SPDX-License-Identifier: BSD-3-Clause
#include <cstdlib>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/home_path.hpp"

namespace lidar_mapping {
namespace {

namespace fs = std::filesystem;

/// HOME as long as this object lives.
class Home {
 public:
  explicit Home(const char* folder) {
    const char* before = std::getenv("HOME");
    if (before != nullptr) before_ = before;
    folder != nullptr ? setenv("HOME", folder, 1) : unsetenv("HOME");
  }
  ~Home() { setenv("HOME", before_.c_str(), 1); }
  Home(const Home&) = delete;
  Home& operator=(const Home&) = delete;

 private:
  std::string before_;
};

// `~/maps`, given to a service, became a folder of the name ~ below the node's working directory.
TEST(PathOfPerson, KnowsTheHomeFolder) {
  const Home home("/home/somebody");
  EXPECT_EQ(expanded_path("~"), fs::path("/home/somebody"));
  EXPECT_EQ(expanded_path("~/maps"), fs::path("/home/somebody/maps"));
  EXPECT_EQ(expanded_path("~/maps/../town"), fs::path("/home/somebody/town"));
}

TEST(PathOfPerson, MakesPathsAbsoluteAndLeavesOthersAlone) {
  EXPECT_EQ(expanded_path("/data/maps"), fs::path("/data/maps"));
  EXPECT_EQ(expanded_path("maps"), fs::current_path() / "maps");
  EXPECT_EQ(expanded_path("a~b"), fs::current_path() / "a~b");
  EXPECT_TRUE(expanded_path("").empty());
}

TEST(PathOfPerson, RefusesOtherUsersAndAMissingHome) {
  EXPECT_THROW(expanded_path("~somebody/maps"), InputError);
  const Home home(nullptr);
  EXPECT_THROW(expanded_path("~/maps"), InputError);
}

}  // namespace
}  // namespace lidar_mapping
