// SPDX-License-Identifier: BSD-3-Clause
#include "scan/isolated_point_filter.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "lidar_mapping/common/order_statistics.hpp"

#include "scan/sweep_order.hpp"

namespace lidar_mapping::front_end {
namespace {

/// Fraction of isolated points from which on they are removed. Measured: clean scans of simulated
/// worlds have 0.002 to 0.008 on a car with 64 beams, and up to 0.025 on leaves and fences.
constexpr double kMinIsolatedFraction = 0.035;
/// Above this fraction the grid does not suit the cloud: nothing is removed. Chosen above the
/// heaviest rain that was simulated (0.3).
constexpr double kMaxIsolatedFraction = 0.6;
/// Weight of the newest scan in the running mean of the fraction. Chosen: half a second at 10 Hz.
constexpr double kLearningRate = 0.2;
/// If the scan is clean, this number of its points is inserted. Measured: a tenth of a scan's time.
constexpr std::size_t kSampledPoints = 8000;
/// They lie in blocks of successive points, which see one part of the surroundings. Chosen: the
/// table of a block stays in the nearest cache.
constexpr std::size_t kBlockSize = 2048;
/// One of this number of points is tested. Chosen: the 1600 of a scan know the fraction to 0.005.
constexpr std::size_t kJudgedStride = 5;
/// If isolated points are removed, this number of points is processed together. Chosen: a sixth of
/// a turn of 64 beams or less, whose table fits into the caches.
constexpr std::size_t kPartSize = 8192;

// Edge length of the cubes. The more points a turn has, the closer are the neighbours. In units of
// the range the edge is this number divided by the square root of the number of points: 0.02 for 64
// beams, 0.04 for 16. Chosen: wider than the rings of 16 beams lie apart (2 degrees, 0.035).
constexpr double kEdgeFactor = 6.5;
// Least edge, chosen so that coordinates in edges (sqrt(2) / kMinEdge at most) stay below
// kAxisMiddle; largest edge, chosen: fewer than 300 points would have cubes as wide as their range.
constexpr double kMinEdge = 0.015;
constexpr double kMaxEdge = 0.4;
/// In units of the point spacing, if the cloud was thinned out. Chosen: a surface then has several
/// points in the eight nearest cubes.
constexpr double kEdgeInSpacings = 3.0;

/// Geometry: a point and two other points make a surface.
constexpr std::uint32_t kMinSupport = 3;
constexpr std::uint32_t kCountBits = 2;  // by the layout of table_: a number up to kMinSupport
constexpr std::uint32_t kCountMask = (1U << kCountBits) - 1;  // by definition
// Layout of the key of a cube, chosen so that level, three axes and kCountBits fill 32 bits.
constexpr std::uint32_t kAxisBits = 8;
constexpr float kAxisMiddle = 128.0F;  // half of what kAxisBits hold, so that cells are positive
/// A float stores its exponent with this number added, in the bits from kExponentShift on; by the
/// format of floats (IEEE 754).
constexpr std::int32_t kExponentBias = 127;
constexpr std::int32_t kExponentShift = 23;
/// Stored exponent of the squared range at which the first level of the grid begins: 2^-2, so 0.5
/// m. A level is an octave of the squared range. Chosen: points that are nearer lie on the vehicle.
constexpr std::int32_t kFirstExponent = kExponentBias - 2;

/// Number of points whose nearest neighbour is searched. Chosen: bounds the time, since each
/// search passes over the whole cloud.
constexpr std::size_t kProbes = 128;
/// m^2. Points without a neighbour within 100 m are ignored. Chosen: a spacing is far smaller.
constexpr float kMaxSpacingSquared = 1e4F;

std::uint32_t key_of(std::uint32_t level, std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  return (((((level << kAxisBits) | x) << kAxisBits) | y) << kAxisBits) | z;
}

std::uint32_t cell_of(float coordinate) { return static_cast<std::uint32_t>(coordinate); }

float nearest_squared(const PointCloud& cloud, std::size_t probe) {
  const Eigen::Vector3f p = cloud.points[probe].position();
  float nearest = std::numeric_limits<float>::max();
  for (const Point& other : cloud.points) {
    const float x = other.x - p.x(), y = other.y - p.y(), z = other.z - p.z();
    const float squared = x * x + y * y + z * z;
    // The point itself, and echoes at the same position, are not neighbours.
    nearest = squared > 1e-8F && squared < nearest ? squared : nearest;
  }
  return nearest;
}

}  // namespace

double point_spacing(const PointCloud& cloud) {
  std::vector<float> spacings;
  const std::size_t step = std::max<std::size_t>(1, cloud.size() / kProbes);
  for (std::size_t i = step / 2; i < cloud.size(); i += step) {
    if (!cloud.points[i].position().allFinite()) continue;
    const float nearest = nearest_squared(cloud, i);
    if (nearest < kMaxSpacingSquared) spacings.push_back(std::sqrt(nearest));
  }
  return static_cast<double>(quantile(std::move(spacings), 0.25));
}

RangeGrid::RangeGrid() { set_edge(kMinEdge, 0.0); }

void RangeGrid::set_edge(double fraction_of_range, double min_edge) {
  for (std::size_t level = 0; level < inverse_edge_.size(); ++level) {
    // Level 1 begins at kFirstExponent.
    const double exponent = static_cast<double>(level) - 1.0 + kFirstExponent - kExponentBias;
    const double range = std::exp2(0.5 * exponent);
    const double edge = std::max(std::max(fraction_of_range, kMinEdge) * range, min_edge);
    inverse_edge_[level] = static_cast<float>(1.0 / edge);
  }
}

void RangeGrid::clear(std::size_t points) {
  std::uint32_t bits = 10;
  while ((std::size_t{1} << bits) < 2 * points) ++bits;
  shift_ = 32 - bits;
  table_.assign(std::size_t{1} << bits, 0U);
}

inline RangeGrid::GridPosition RangeGrid::position_of(const Point& point) const {
  const float x = point.x, y = point.y, z = point.z;
  const float squared = x * x + y * y + z * z;
  std::int32_t bits = 0;
  std::memcpy(&bits, &squared, sizeof(bits));
  const std::int32_t level = (bits >> kExponentShift) - kFirstExponent + 1;
  // NaN has the highest exponent, so it gets no level.
  if (level < 1 || level > static_cast<std::int32_t>(kMaxLevels)) return {};
  const float scale = inverse_edge_[level];
  return {static_cast<std::uint32_t>(level), x * scale + kAxisMiddle, y * scale + kAxisMiddle,
          z * scale + kAxisMiddle};
}

/// The entry of the cube, or the free entry where it would be inserted.
inline std::size_t RangeGrid::find(std::uint32_t key) const {
  const std::uint32_t* const table = table_.data();
  const std::size_t mask = table_.size() - 1;
  std::size_t slot = (key * 0x9E3779B1U) >> shift_;
  while (table[slot] != 0 && table[slot] >> kCountBits != key) slot = (slot + 1) & mask;
  return slot;
}

void RangeGrid::insert(const Point* points, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    const GridPosition position = position_of(points[i]);
    if (position.level == 0) continue;
    const std::uint32_t key =
        key_of(position.level, cell_of(position.x), cell_of(position.y), cell_of(position.z));
    // Without branches: every other one would be predicted wrongly.
    std::uint32_t& entry = table_[find(key)];
    const std::uint32_t before = entry == 0 ? key << kCountBits : entry;
    entry = before + static_cast<std::uint32_t>((before & kCountMask) < kMinSupport);
  }
}

inline std::uint32_t RangeGrid::count_at(std::uint32_t key) const {
  return table_[find(key)] & kCountMask;
}

bool RangeGrid::is_isolated(const Point& point) const {
  const GridPosition position = position_of(point);
  if (position.level == 0) return false;
  const std::uint32_t x = cell_of(position.x), y = cell_of(position.y), z = cell_of(position.z);
  std::uint32_t count = count_at(key_of(position.level, x, y, z));
  if (count >= kMinSupport) return false;
  // The neighbour on the nearer side of each axis.
  const auto beside = [](float value, std::uint32_t cell) {
    return value - static_cast<float>(cell) < 0.5F ? cell - 1 : cell + 1;
  };
  const std::uint32_t nx = beside(position.x, x), ny = beside(position.y, y),
                      nz = beside(position.z, z);
  for (std::uint32_t corner = 1; corner < 8 && count < kMinSupport; ++corner) {
    count += count_at(key_of(position.level, (corner & 1U) != 0 ? nx : x,
                             (corner & 2U) != 0 ? ny : y, (corner & 4U) != 0 ? nz : z));
  }
  return count < kMinSupport;
}

std::size_t IsolatedPointFilter::count_isolated(const PointCloud& cloud, std::size_t begin,
                                                std::size_t end) const {
  std::size_t isolated = 0;
  for (std::size_t i = begin; i < end; i += kJudgedStride) {
    isolated += grid_.is_isolated(cloud.points[i]) ? 1 : 0;
  }
  return isolated;
}

/// Each block uses a table of its own, which is so small that it stays in the nearest cache.
double IsolatedPointFilter::isolated_fraction_in_blocks(const PointCloud& cloud) {
  const std::size_t parts = std::max<std::size_t>(1, cloud.size() / kSampledPoints);
  std::size_t judged = 0, isolated = 0;
  const std::size_t first = (next_block_++ % parts) * kBlockSize;
  for (std::size_t begin = first; begin < cloud.size(); begin += parts * kBlockSize) {
    const std::size_t end = std::min(begin + kBlockSize, cloud.size());
    grid_.clear(kBlockSize);
    grid_.insert(cloud.points.data() + begin, end - begin);
    isolated += count_isolated(cloud, begin, end);
    judged += (end - begin + kJudgedStride - 1) / kJudgedStride;
  }
  return judged == 0 ? 0.0 : static_cast<double>(isolated) / static_cast<double>(judged);
}

void IsolatedPointFilter::set_cube_edge(const PointCloud& cloud) {
  const double points = static_cast<double>(std::max<std::size_t>(1, cloud.size()));
  const double fraction = std::min(kMaxEdge, kEdgeFactor / std::sqrt(points));
  grid_.set_edge(fraction, kEdgeInSpacings * spacing_);
}

void IsolatedPointFilter::copy_supported(const PointCloud& cloud, std::size_t begin,
                                         std::size_t end) {
  grid_.clear(end - begin);
  grid_.insert(cloud.points.data() + begin, end - begin);
  for (std::size_t i = begin; i < end; ++i) {
    if (grid_.is_isolated(cloud.points[i])) continue;
    filtered_.cloud.points.push_back(cloud.points[i]);
    if (cloud.has_times()) filtered_.cloud.times.push_back(cloud.times[i]);
  }
}

double IsolatedPointFilter::filter(const Scan& scan) {
  filtered_.stamp = scan.stamp;
  filtered_.cloud.points.clear();
  filtered_.cloud.times.clear();
  const std::size_t size = scan.cloud.size();
  const std::size_t part = in_sweep_order(scan.cloud) ? kPartSize : std::max<std::size_t>(1, size);
  for (std::size_t begin = 0; begin < size; begin += part) {
    copy_supported(scan.cloud, begin, std::min(begin + part, size));
  }
  const double kept = static_cast<double>(filtered_.cloud.size());
  return 1.0 - kept / static_cast<double>(std::max<std::size_t>(1, size));
}

void IsolatedPointFilter::learn(double fraction) {
  mean_isolated_fraction_ =
      mean_isolated_fraction_ < 0.0
          ? fraction
          : mean_isolated_fraction_ + kLearningRate * (fraction - mean_isolated_fraction_);
}

const Scan& IsolatedPointFilter::without_isolated_points(const Scan& scan) {
  set_cube_edge(scan.cloud);
  if (mean_isolated_fraction_ <= kMinIsolatedFraction) {
    const double fraction = isolated_fraction_in_blocks(scan.cloud);
    if (fraction <= kMinIsolatedFraction) {
      learn(fraction);
      return scan;
    }
    if (!spacing_known_) {
      spacing_ = point_spacing(scan.cloud);
      spacing_known_ = true;
      set_cube_edge(scan.cloud);
    }
  }
  const double fraction = filter(scan);
  learn(fraction);
  return mean_isolated_fraction_ > kMinIsolatedFraction && fraction <= kMaxIsolatedFraction
             ? filtered_
             : scan;
}

}  // namespace lidar_mapping::front_end
