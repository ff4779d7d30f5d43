#include "lidar_mapping/ros/open_bag.hpp"

#include <filesystem>
#include <fstream>

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping::ros_border {

namespace {

/// Whether it begins as every bag does.
bool is_bag(const std::string& path) {
  const std::string magic = "#ROSBAG V";
  std::string start(magic.size(), '\0');
  std::ifstream(path, std::ios::binary)
      .read(start.data(), static_cast<std::streamsize>(start.size()));
  return start == magic;
}

}  // namespace

std::unique_ptr<rosbag::Bag> open_bag(const std::string& path) {
  const std::string problem = "cannot read the bag " + path + ": ";
  if (std::filesystem::is_directory(path)) {
    throw FileError(problem + "it is a folder; name the bags in it");
  }
  if (!std::filesystem::is_regular_file(path)) {
    throw FileError(problem + "there is no such file; check its path");
  }
  if (std::filesystem::file_size(path) == 0) {
    throw FileError(problem + "it is empty; copy or record it again");
  }
  try {
    return std::make_unique<rosbag::Bag>(path, rosbag::bagmode::Read);
  } catch (const rosbag::BagUnindexedException&) {
    throw FileError(problem +
                    "it has no index, as its recording was broken off; rosbag reindex makes one");
  } catch (const rosbag::BagIOException& error) {
    const std::string remedy = is_bag(path) ? "its end is missing; rosbag reindex saves the rest"
                                            : "it is no bag; rosbag info says what one holds";
    throw FileError(problem + remedy + " (" + error.what() + ")");
  } catch (const rosbag::BagException& error) {
    throw FileError(problem + error.what() +
                    "; if rosbag info cannot read it either, it is damaged");
  }
}

}  // namespace lidar_mapping::ros_border
