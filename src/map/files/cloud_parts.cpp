// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/map/cloud_parts.hpp"

#include <vector>

#include "lidar_mapping/common/list_file.hpp"
#include "lidar_mapping/map/map_files.hpp"

namespace lidar_mapping::map {

namespace {

/// Parts of a map in an unnamed temporary file.
class PointFile {
 public:
  explicit PointFile(const std::filesystem::path& directory) : parts_(directory) {}

  void add(const PointCloud& part) {
    parts_.put(bounds_.size(), part.points);
    CloudParts::Area& bounds = bounds_.emplace_back();
    for (const Point& point : part.points) bounds.extend(point.position().head<2>());
  }

  void for_each(const CloudParts::Sink& sink) const {
    for_each_of(sink, [](std::size_t) { return true; });
  }
  void for_each_near(const CloudParts::Area& area, const CloudParts::Sink& sink) const {
    for_each_of(sink, [&](std::size_t i) { return area.intersects(bounds_[i]); });
  }

 private:
  template <typename IsWanted>
  void for_each_of(const CloudParts::Sink& sink, const IsWanted& is_wanted) const {
    for (std::size_t i = 0; i < bounds_.size(); ++i) {
      if (is_wanted(i)) sink({parts_.get(i), {}});
    }
  }

  ListFile<std::size_t, Point> parts_;
  std::vector<CloudParts::Area> bounds_;
};

CloudParts parts_of(const std::shared_ptr<const PointFile>& file) {
  return CloudParts([file](const CloudParts::Sink& sink) { file->for_each(sink); },
                    [file](const CloudParts::Area& area, const CloudParts::Sink& sink) {
                      file->for_each_near(area, sink);
                    });
}

}  // namespace

CloudParts stored_parts(const TileSource& tiles, const std::filesystem::path& directory) {
  const auto file = std::make_shared<PointFile>(directory);
  tiles([&](const MapTile& tile) { file->add(in_map_frame(tile)); });
  return parts_of(file);
}

CloudParts stored_parts(const CloudParts& parts,
                        const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& move,
                        const std::filesystem::path& directory) {
  const auto file = std::make_shared<PointFile>(directory);
  parts.for_each([&](const PointCloud& part) {
    PointCloud moved = part;
    for (Point& point : moved.points) {
      const Eigen::Vector3f p = move(point.position().cast<double>()).cast<float>();
      point.x = p.x();
      point.y = p.y();
      point.z = p.z();
    }
    file->add(moved);
  });
  return parts_of(file);
}

}  // namespace lidar_mapping::map
