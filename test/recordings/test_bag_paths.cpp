// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "bag_paths.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::recordings {
namespace {

namespace fs = std::filesystem;
using Paths = std::vector<std::string>;

class BagPaths : public testing::Test {
 protected:
  std::string file(const std::string& name) {
    const fs::path path = folder_.path() / name;
    fs::create_directories(path.parent_path());
    std::ofstream(path) << "there";
    return path;
  }
  Paths of(const Paths& paths) const { return with_bags_of_folders(paths); }

  test::TemporaryFolder folder_;
  const std::string drive_ = folder_.path() / "drive";
};

TEST_F(BagPaths, OfAFolderAreSortedByName) {
  const std::string c = file("drive/c.bag"), a = file("drive/a.bag"), b = file("drive/b.bag");
  file("drive/notes.txt");
  fs::create_directory(folder_.path() / "drive/folder.bag");
  EXPECT_EQ(of({drive_}), (Paths{a, b, c}));
}

TEST_F(BagPaths, StayInTheOrderOfTheArguments) {
  const std::string a = file("drive/a.bag"), z = file("z.bag");
  EXPECT_EQ(of({z, drive_, "absent.bag"}), (Paths{z, a, "absent.bag"}));
}

/// A recording of ROS 2 beside bags was made of them, or they of it.
TEST_F(BagPaths, OfROS1ComeBeforeThoseOfROS2) {
  const std::string db3 = file("drive/drive_0.db3");
  EXPECT_EQ(of({drive_}), Paths{db3});
  const std::string bag = file("drive/drive.bag");
  EXPECT_EQ(of({drive_}), Paths{bag});
}

/// So that opening them says why they are not read.
TEST_F(BagPaths, NameWhatCannotBeRead) {
  const std::string mcap = file("drive/drive_0.mcap");
  EXPECT_EQ(of({drive_}), Paths{mcap});
}

TEST_F(BagPaths, LeaveAFolderWithoutBagsAsItIs) {
  file("drive/000000.pcd");
  EXPECT_EQ(of({drive_}), Paths{drive_});
  EXPECT_EQ(of({}), Paths{});
}

}  // namespace
}  // namespace lidar_mapping::recordings
