#include "lidar_mapping/loop_closing/surface.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lidar_mapping::loop_closing {

namespace {

constexpr std::size_t kNeighbours = 10;
constexpr double kPlanarity = 0.08;      // smallest to middle eigenvalue
constexpr float kClearance = 0.6F;       // m above the ground
constexpr double kGroundCell = 2.5;      // m; a 3 x 3 block reaches 3.75 m from its middle
constexpr double kGroundExtent = 250.0;  // m; what is further away counts as ground

/// Second moments of points about their mean.
struct Scatter {
  double xx = 0.0, yy = 0.0, zz = 0.0, xy = 0.0, yz = 0.0, zx = 0.0;

  void add(const Eigen::Vector3d& d) {
    xx += d.x() * d.x();
    yy += d.y() * d.y();
    zz += d.z() * d.z();
    xy += d.x() * d.y();
    yz += d.y() * d.z();
    zx += d.z() * d.x();
  }
  double trace() const { return xx + yy + zz; }
  double minors() const { return xx * yy + yy * zz + zz * xx - xy * xy - yz * yz - zx * zx; }
  double determinant() const {
    return xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * zx) + zx * (xy * yz - yy * zx);
  }
};

Scatter scatter_of(const std::vector<Eigen::Vector3f>& points,
                   const std::vector<KdTree::Neighbour>& neighbours) {
  Eigen::Vector3f mean = Eigen::Vector3f::Zero();
  for (const auto& n : neighbours) mean += points[n.index];
  mean /= static_cast<float>(neighbours.size());
  Scatter scatter;
  for (const auto& n : neighbours) scatter.add((points[n.index] - mean).cast<double>());
  return scatter;
}

/// Root of the characteristic polynomial by Newton's method from zero, where all eigenvalues are to
/// the right: it never steps too far, and is there soon if the smallest one is far from the others.
double smallest_eigenvalue(double trace, double minors, double determinant) {
  constexpr int kMaxSteps = 20;
  double value = 0.0;
  for (int i = 0; i < kMaxSteps; ++i) {
    const double slope = (2.0 * trace - 3.0 * value) * value - minors;
    if (!(slope < 0.0)) break;
    const double step = -(((trace - value) * value - minors) * value + determinant) / slope;
    value += step;
    if (!(std::abs(step) > 1e-9 * value)) break;
  }
  return std::max(value, 0.0);
}

/// The larger of two remaining eigenvalues has no say.
double middle_eigenvalue(double trace, double minors, double smallest) {
  const double sum = trace - smallest;
  const double product = minors - smallest * sum;
  return 0.5 * (sum - std::sqrt(std::max(0.0, sum * sum - 4.0 * product)));
}

Eigen::Vector3f planar_normal(const Scatter& s) {
  const double smallest = smallest_eigenvalue(s.trace(), s.minors(), s.determinant());
  if (!(smallest < kPlanarity * middle_eigenvalue(s.trace(), s.minors(), smallest))) {
    return Eigen::Vector3f::Zero();
  }
  // All rows are at right angles to the eigenvector; the longest product knows it best.
  const Eigen::Vector3d x(s.xx - smallest, s.xy, s.zx);
  const Eigen::Vector3d y(s.xy, s.yy - smallest, s.yz);
  const Eigen::Vector3d z(s.zx, s.yz, s.zz - smallest);
  Eigen::Vector3d normal = x.cross(y);
  for (const Eigen::Vector3d& other : {y.cross(z), z.cross(x)}) {
    if (other.squaredNorm() > normal.squaredNorm()) normal = other;
  }
  return normal.normalized().cast<float>();
}

/// Square cells around the origin; the outermost ones are never given out.
class GroundCells {
 public:
  static constexpr int kWidth = static_cast<int>(2.0 * kGroundExtent / kGroundCell) + 2;
  static constexpr int kCount = kWidth * kWidth;

  /// Number of the cell; -1 outside of the grid.
  static int of(const Eigen::Vector3f& p) {
    constexpr double kMiddle = kWidth / 2;  // added first, so that casting rounds down
    const double x = p.x() / kGroundCell + kMiddle;
    const double y = p.y() / kGroundCell + kMiddle;
    if (!(x >= 1.0 && y >= 1.0 && x < kWidth - 1 && y < kWidth - 1)) return -1;
    return static_cast<int>(y) * kWidth + static_cast<int>(x);
  }
};

/// Lowers each value to the least of itself and those `step` before and behind.
void spread_lowest(std::vector<float>& heights, int step) {
  const std::vector<float> own = heights;
  const auto count = static_cast<int>(own.size());
  for (int i = step; i < count - step; ++i) {
    heights[i] = std::min(own[i], std::min(own[i - step], own[i + step]));
  }
}

}  // namespace

std::vector<Eigen::Vector3f> positions(const PointCloud& cloud) {
  std::vector<Eigen::Vector3f> result;
  result.reserve(cloud.size());
  for (const Point& point : cloud.points) {
    if (point.position().allFinite()) result.push_back(point.position());
  }
  return result;
}

SurfaceCloud::SurfaceCloud(std::vector<Eigen::Vector3f> points)
    : tree_(std::move(points)),
      normals_(tree_.points().size(), Eigen::Vector3f::Zero()),
      is_known_(tree_.points().size(), false) {}

const Eigen::Vector3f& SurfaceCloud::normal(std::size_t index) const {
  if (is_known_[index]) return normals_[index];
  is_known_[index] = true;
  const auto neighbours = tree_.nearest(tree_.points()[index], kNeighbours);
  if (neighbours.size() == kNeighbours)
    normals_[index] = planar_normal(scatter_of(tree_.points(), neighbours));
  return normals_[index];
}

std::vector<bool> above_ground(const std::vector<Eigen::Vector3f>& points) {
  std::vector<int> cells(points.size());
  std::vector<float> lowest(GroundCells::kCount, std::numeric_limits<float>::infinity());
  for (std::size_t i = 0; i < points.size(); ++i) {
    cells[i] = GroundCells::of(points[i]);
    if (cells[i] >= 0) lowest[cells[i]] = std::min(lowest[cells[i]], points[i].z());
  }
  // To 3 x 3 blocks of cells.
  spread_lowest(lowest, 1);
  spread_lowest(lowest, GroundCells::kWidth);
  std::vector<bool> result(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    result[i] = cells[i] >= 0 && points[i].z() > lowest[cells[i]] + kClearance;
  }
  return result;
}

}  // namespace lidar_mapping::loop_closing
