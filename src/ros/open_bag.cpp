#include "lidar_mapping/ros/open_bag.hpp"

#include <filesystem>

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping::ros_border {

std::unique_ptr<rosbag::Bag> open_bag(const std::string& path) {
  if (!std::filesystem::is_regular_file(path)) {
    throw FileError("cannot read the bag " + path + ": there is no such file; check its path");
  }
  try {
    return std::make_unique<rosbag::Bag>(path, rosbag::bagmode::Read);
  } catch (const rosbag::BagUnindexedException&) {
    throw FileError("cannot read the bag " + path +
                    ": it has no index, as its recording was broken off; rosbag reindex makes one");
  } catch (const rosbag::BagException& error) {
    throw FileError("cannot read the bag " + path + ": " + error.what() +
                    "; if rosbag info cannot read it either, it is damaged or no bag");
  }
}

}  // namespace lidar_mapping::ros_border
