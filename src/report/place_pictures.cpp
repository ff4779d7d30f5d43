// SPDX-License-Identifier: BSD-3-Clause
#include "place_pictures.hpp"

#include <algorithm>
#include <cmath>

namespace lidar_mapping::report {

namespace {

constexpr float kReach = 15.0F;  // shown distance to the side and along, m; chosen: a street
// Of a pass and place. Chosen: bounds the size of the page; more points would overlap.
constexpr std::size_t kPicturePoints = 9000;
// Points of a pass; with fewer a wider slice is shown. Chosen: fewer show no walls.
constexpr std::size_t kFewestShown = 300;

/// Limits of the points that a picture shows, m in the axes of the vehicle.
struct Slice {
  Eigen::Vector3f low;
  Eigen::Vector3f high;
  const char* title;
};

constexpr float kAll = 1000.0F;  // m; chosen: beyond all points of a place

/// Slices from narrow to wide: a narrow one shows the distance of passes best, but may be empty.
const std::vector<Slice>& slices(View view) {
  static const std::vector<Slice> above = {
      {{-kReach, -kReach, 0.5F}, {kReach, kReach, 3.0F}, "From above, 0.5 to 3 m up"},
      {{-kReach, -kReach, 0.2F}, {kReach, kReach, 8.0F}, "From above, 0.2 to 8 m up"},
      {{-kReach, -kReach, -kAll}, {kReach, kReach, kAll}, "From above"},
      {{-kAll, -kAll, -kAll}, {kAll, kAll, kAll}, "From above, all"}};
  static const std::vector<Slice> across = {
      {{-1.5F, -kReach, -kAll}, {1.5F, kReach, 8.0F}, "Across, a slice of 3 m"},
      {{-5.0F, -kReach, -kAll}, {5.0F, kReach, 8.0F}, "Across, a slice of 10 m"},
      {{-kReach, -kReach, -kAll}, {kReach, kReach, kAll}, "Across, a slice of 30 m"},
      {{-kAll, -kAll, -kAll}, {kAll, kAll, kAll}, "Across, all"}};
  return view == View::kFromAbove ? above : across;
}

std::vector<Eigen::Vector3f> inside(const std::vector<Eigen::Vector3f>& points,
                                    const Slice& slice) {
  std::vector<Eigen::Vector3f> chosen;
  for (const Eigen::Vector3f& p : points) {
    if ((p.array() >= slice.low.array()).all() && (p.array() <= slice.high.array()).all()) {
      chosen.push_back(p);
    }
  }
  return chosen;
}

/// Coordinates in a picture, mm: (along, left) from above or (left, up) across.
json::Json rows_of(const std::vector<Eigen::Vector3f>& points, View view) {
  const bool from_above = view == View::kFromAbove;
  json::Json rows = json::Json::array();
  const std::size_t step = points.size() / kPicturePoints + 1;
  const auto millimetres = [](float value) { return std::round(1000.0F * value); };
  for (std::size_t i = 0; i < points.size(); i += step) {
    const Eigen::Vector3f& p = points[i];
    rows.push_back(
        {millimetres(from_above ? p.x() : p.y()), millimetres(from_above ? p.y() : p.z())});
  }
  return rows;
}

}  // namespace

json::Json place_picture(const map_quality::PassPoints& points, View view) {
  for (const Slice& slice : slices(view)) {
    const auto earlier = inside(points.earlier, slice);
    const auto later = inside(points.later, slice);
    const bool is_last = &slice == &slices(view).back();
    if (!is_last && std::min(earlier.size(), later.size()) < kFewestShown) continue;
    return {{"title", slice.title}, {"passes", {rows_of(earlier, view), rows_of(later, view)}}};
  }
  return {};
}

}  // namespace lidar_mapping::report
