// SPDX-License-Identifier: BSD-3-Clause
#include "gis/change_files.hpp"

#include "lidar_mapping/common/dates.hpp"

#include "gis/geojson.hpp"

namespace lidar_mapping::map {

namespace {

using json::Json;
using moving_objects::Change;
using moving_objects::ChangeKind;
using moving_objects::Visit;

/// The corners of the box's lower face, counter-clockwise from above.
std::vector<Eigen::Vector3d> footprint(const Change& change) {
  const Eigen::Vector3d &a = change.low, &b = change.high;
  return {
      {a.x(), a.y(), a.z()}, {b.x(), a.y(), a.z()}, {b.x(), b.y(), a.z()}, {a.x(), b.y(), a.z()}};
}

Json properties_of(const Change& change, std::size_t number, const std::vector<Visit>& visits) {
  const auto [after, before] = interval_of(change, visits);
  const Eigen::Vector3d size = change.high - change.low;
  return {{"number", number},
          {"kind", moving_objects::to_string(change.kind)},
          {"after", iso_date(after)},
          {"before", iso_date(before)},
          {"visit_without", change.absent + 1},
          {"visit_with", change.present + 1},
          {"size_x_m", rounded_number(size.x())},
          {"size_y_m", rounded_number(size.y())},
          {"height_m", rounded_number(size.z())},
          {"voxels", change.points.size()}};
}

void append(const Change& change, std::size_t number, PointCloud& all) {
  const float sign = change.kind == ChangeKind::kAppeared ? 1.0F : -1.0F;
  for (Point point : change.points.points) {
    point.intensity = sign * static_cast<float>(number);
    all.points.push_back(point);
  }
}

}  // namespace

std::pair<Stamp, Stamp> interval_of(const Change& change, const std::vector<Visit>& visits) {
  const Visit& absent = visits[change.absent];
  const Visit& present = visits[change.present];
  return change.kind == ChangeKind::kAppeared ? std::make_pair(absent.end, present.begin)
                                              : std::make_pair(present.end, absent.begin);
}

Files write_changes(const std::vector<Change>& changes, const std::vector<Visit>& visits,
                    const std::optional<GeodeticDatum>& datum,
                    const std::filesystem::path& directory) {
  const GeoJson geojson(datum);
  Json features = Json::array();
  PointCloud points;
  for (std::size_t i = 0; i < changes.size(); ++i) {
    features.push_back(
        feature(geojson.polygon(footprint(changes[i])), properties_of(changes[i], i + 1, visits)));
    append(changes[i], i + 1, points);
  }
  Files files = {geojson.write("changes", features, directory)};
  const std::filesystem::path points_file = directory / "changes.pcd";
  if (points.empty()) {
    std::filesystem::remove(points_file);
    return files;
  }
  write_pcd(points_file, points);
  files.push_back(points_file);
  return files;
}

}  // namespace lidar_mapping::map
