// SPDX-License-Identifier: BSD-3-Clause
#include <vector>

#include "lidar_mapping/common/order_statistics.hpp"
#include "lidar_mapping/common/text.hpp"

#include "checks/input_checks.hpp"

namespace lidar_mapping::preprocessing {

namespace {

constexpr std::size_t kSample = 2000;  // points; chosen: medians are then good to some per cent
// m, of the median distance from the middle. Chosen: beyond what LiDARs see at the half of their
// points (5 to 50 m), and below a room of 3 m in centimetres.
constexpr float kMaxRadius = 150.0F;
// m, of such a radius: more is in millimetres. Chosen between 15 m in centimetres and 3 m in
// millimetres, which are equally far off.
constexpr float kMinRadiusOfMillimetres = 2000.0F;
// m from the sensor to the middle, and in multiples of the radius. Chosen: a sensor that looks
// ahead has the middle of its points at some tens of metres; one with a narrow view on a drone sees
// some 40 m around a middle that is 150 m below it.
constexpr float kMaxDistance = 100.0F;
constexpr float kMaxDistanceRatio = 10.0F;

/// Up to about kSample points, spread over the cloud.
std::vector<Eigen::Vector3f> sample_of(const PointCloud& cloud) {
  const std::size_t step = cloud.size() / kSample + 1;
  std::vector<Eigen::Vector3f> sample;
  for (std::size_t i = 0; i < cloud.size(); i += step) {
    const Eigen::Vector3f p = cloud.points[i].position();
    if (p.allFinite() && p.squaredNorm() > 0.0F) sample.push_back(p);
  }
  return sample;
}

}  // namespace

std::optional<CloudExtent> extent_of(const PointCloud& cloud) {
  const std::vector<Eigen::Vector3f> sample = sample_of(cloud);
  if (sample.empty()) return std::nullopt;
  CloudExtent extent;
  std::vector<float> values(sample.size());
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < sample.size(); ++i) values[i] = sample[i][axis];
    extent.middle[axis] = median(values);
  }
  for (std::size_t i = 0; i < sample.size(); ++i) values[i] = (sample[i] - extent.middle).norm();
  extent.radius = median(values);
  return extent;
}

void check_extent(const CloudExtent& extent, InputReport& report) {
  const float distance = extent.middle.norm();
  if (extent.radius > kMaxRadius) {
    add_fault(report,
              formatted("half of the points are more than %.0f m away, as if they were in %s",
                        extent.radius,
                        extent.radius > kMinRadiusOfMillimetres ? "millimetres" : "centimetres"),
              "the driver must publish metres (REP 103)");
  } else if (distance > kMaxDistance && distance > kMaxDistanceRatio * extent.radius) {
    add_fault(report,
              formatted("the points lie around (%.0f, %.0f, %.0f) m and not around the sensor, as "
                        "in a frame of the world",
                        extent.middle.x(), extent.middle.y(), extent.middle.z()),
              "record the clouds of the driver, or with them the /tf that moves the vehicle in the "
              "frame of the clouds");
  }
}

}  // namespace lidar_mapping::preprocessing
