#include "lidar_mapping/preprocessing/scan_pass.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "lidar_mapping/common/elevation_shift.hpp"

namespace lidar_mapping::preprocessing {

namespace {

constexpr double kPi = 3.14159265358979323846;
/// Points without an echo lie in the sensor's origin; no LiDAR measures a centimetre.
constexpr float kNoEcho = 0.01F;

/// A rigid motion as the columns of [R | t], each a vector of four floats: a point costs three
/// multiplications and additions of whole vectors.
struct alignas(16) Columns {
  Eigen::Vector4f x, y, z, t;

  Eigen::Vector4f operator*(const Point& p) const { return x * p.x + y * p.y + z * p.z + t; }
};

Columns columns(const Pose& pose) {
  const Eigen::Matrix4f m = pose.matrix().cast<float>();
  return {m.col(0), m.col(1), m.col(2), m.col(3)};
}

/// The same place for every point.
class FixedMotion {
 public:
  explicit FixedMotion(const Pose& T_base_sensor) : columns_(columns(T_base_sensor)) {}
  Eigen::Vector4f moved(const Point& point, std::size_t) const { return columns_ * point; }

 private:
  Columns columns_;
};

/// By the points' times, from a table of motions so fine that the nearest one serves: at 30 m/s and
/// 1 rad/s it is off by 1 mm and 0.05 mrad.
class TimedMotion {
 public:
  TimedMotion(const ScanMotion& motion, const Pose& T_base_sensor, const std::vector<float>& times)
      : times_(times.data()),
        begin_(static_cast<float>(motion.begin)),
        rate_(static_cast<float>(kFiner / motion.step)),
        last_(static_cast<float>(kFiner * (motion.T_stamp_knot.size() - 1))) {
    std::vector<Columns> knots;
    for (const Pose& T_stamp_knot : motion.T_stamp_knot) {
      knots.push_back(columns(T_stamp_knot * T_base_sensor));
    }
    table_.reserve(kFiner * knots.size());
    for (std::size_t k = 0; k + 1 < knots.size(); ++k) {
      for (int part = 0; part < kFiner; ++part) {
        table_.push_back(between(knots[k], knots[k + 1], static_cast<float>(part) / kFiner));
      }
    }
    table_.push_back(knots.back());
  }

  Eigen::Vector4f moved(const Point& point, std::size_t index) const {
    const float position = std::min(std::max((times_[index] - begin_) * rate_, 0.0F), last_);
    return table_[static_cast<std::size_t>(static_cast<int>(position + 0.5F))] * point;
  }

 private:
  static constexpr int kFiner = 64;

  static Columns between(const Columns& a, const Columns& b, float share) {
    return {a.x + share * (b.x - a.x), a.y + share * (b.y - a.y), a.z + share * (b.z - a.z),
            a.t + share * (b.t - a.t)};
  }

  const float* times_;
  float begin_, rate_, last_;
  std::vector<Columns> table_;
};

bool is_inside(const Eigen::Vector4f& p, const PassLimits& limits) {
  return p.x() > limits.box_min.x() && p.x() < limits.box_max.x() && p.y() > limits.box_min.y() &&
         p.y() < limits.box_max.y() && p.z() > limits.box_min.z() && p.z() < limits.box_max.z();
}

/// Writes never overtake reads, so the scan shrinks in place.
template <bool has_times, bool keeps_times, typename Motion>
std::size_t pass(PointCloud& cloud, const PassLimits& limits, const Motion& motion) {
  Point* const points = cloud.points.data();
  float* const times = cloud.times.data();
  const std::size_t count = cloud.size();
  const bool has_box = (limits.box_max - limits.box_min).minCoeff() > 0.0F;
  std::size_t kept = 0;
  std::size_t not_finite = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Point point = points[i];
    const float squared = point.x * point.x + point.y * point.y + point.z * point.z;
    if (!(squared >= limits.near_squared && squared <= limits.far_squared)) {
      if (!std::isfinite(squared)) ++not_finite;
      continue;
    }
    if constexpr (has_times) {
      if (!std::isfinite(times[i])) {
        ++not_finite;
        continue;
      }
    }
    const Eigen::Vector4f p = motion.moved(point, i);
    if (has_box && is_inside(p, limits)) continue;
    Eigen::Map<Eigen::Vector4f>(&points[kept].x) = p;  // one store, then the intensity over it
    points[kept].intensity = point.intensity;
    if constexpr (keeps_times) times[kept] = times[i];
    ++kept;
  }
  cloud.points.resize(kept);
  cloud.times.resize(keeps_times ? kept : 0);
  return not_finite;
}

}  // namespace

PassLimits::PassLimits(const PreprocessingConfig& config)
    : box_min(static_cast<float>(config.vehicle_box[0]), static_cast<float>(config.vehicle_box[1]),
              static_cast<float>(config.vehicle_box[2])),
      box_max(static_cast<float>(config.vehicle_box[3]), static_cast<float>(config.vehicle_box[4]),
              static_cast<float>(config.vehicle_box[5])) {
  const bool cut = config.use_distance_filter;
  const float near = cut ? static_cast<float>(config.distance_near_thresh) : 0.0F;
  near_squared = std::max(near, kNoEcho) * std::max(near, kNoEcho);
  const auto far = static_cast<float>(config.distance_far_thresh);
  far_squared = cut ? far * far : std::numeric_limits<float>::max();
}

std::size_t move_to_base(PointCloud& cloud, const Pose& T_base_sensor, const PassLimits& limits,
                         const ScanMotion* motion, PointTimesAfter times) {
  const FixedMotion fixed(T_base_sensor);
  if (!cloud.has_times()) return pass<false, false>(cloud, limits, fixed);
  if (motion == nullptr) return pass<true, true>(cloud, limits, fixed);
  const TimedMotion timed(*motion, T_base_sensor, cloud.times);
  return times == PointTimesAfter::kKept ? pass<true, true>(cloud, limits, timed)
                                         : pass<true, false>(cloud, limits, timed);
}

void correct_vertical_angle(PointCloud& cloud, double angle) {
  const ElevationShift shift(angle);
  for (Point& p : cloud.points) shift(p.x, p.y, p.z);
}

void set_times_from_azimuth(PointCloud& cloud, const PreprocessingConfig& config) {
  const double sign = config.scan_direction == ScanDirection::kClockwise ? -1.0 : 1.0;
  const auto turns_per_radian = static_cast<float>(sign / (2.0 * kPi));
  const auto start = static_cast<float>(sign * config.scan_start_azimuth_deg / 360.0);
  const auto period = static_cast<float>(config.scan_period);
  cloud.times.resize(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Point& p = cloud.points[i];
    const float turns = std::atan2(p.y, p.x) * turns_per_radian - start;
    cloud.times[i] = period * (turns - std::floor(turns));
  }
}

}  // namespace lidar_mapping::preprocessing
