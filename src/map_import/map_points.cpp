// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <string>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/number_words.hpp"
#include "lidar_mapping/common/pcd_header.hpp"
#include "lidar_mapping/common/point_field_names.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/session/pcd_points.hpp"

#include "map_input.hpp"

// The points of one PCD file.
namespace lidar_mapping::map_import {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kPart = 100'000;  // points, 3 MB; chosen: the disk is fast with that
// m. Chosen: beyond it (2^20) floats of 4 bytes are 0.125 m apart, as far as surfaces are thick.
constexpr double kMostOfFloats = 1'048'576.0;

/// One number of a point.
struct NumberField {
  std::size_t offset = 0;  ///< bytes from the point's beginning
  std::size_t size = 0;    ///< bytes
  char type = 'F';         ///< as in PcdField
};

template <typename Number>
double number_at(const std::uint8_t* bytes) {
  Number number{};
  std::memcpy(&number, bytes, sizeof number);
  return static_cast<double>(number);
}

double read_number(const std::uint8_t* point, const NumberField& field) {
  const std::uint8_t* const bytes = point + field.offset;
  if (field.type == 'F') {
    return field.size == 4 ? number_at<float>(bytes) : number_at<double>(bytes);
  }
  const bool has_sign = field.type == 'I';
  switch (field.size) {
    case 1:
      return has_sign ? number_at<std::int8_t>(bytes) : number_at<std::uint8_t>(bytes);
    case 2:
      return has_sign ? number_at<std::int16_t>(bytes) : number_at<std::uint16_t>(bytes);
    case 4:
      return has_sign ? number_at<std::int32_t>(bytes) : number_at<std::uint32_t>(bytes);
    default:
      return has_sign ? number_at<std::int64_t>(bytes) : number_at<std::uint64_t>(bytes);
  }
}

class PointReader {
 public:
  PointReader(const fs::path& path, const MapPointSink& sink)
      : path_(path), sink_(sink), header_(read_pcd_header(path)) {
    const char* const names[] = {"x", "y", "z"};
    for (int axis = 0; axis < 3; ++axis) {
      const auto field = find(names[axis]);
      if (!field || field->type != 'F') fail("it has no fields x y z of floats");
      axes_[axis] = *field;
    }
    for (const char* name : kIntensityNames) {
      if (!intensity_) intensity_ = find(name);
    }
  }

  void read() {
    if (header_.points == 0) return;
    if (header_.data == "binary") return read_parts();
    const pcl::PCLPointCloud2 cloud = session::read_pcd_points(path_, header_);
    for (std::size_t first = 0; first < header_.points; first += kPart) {
      pass_on(cloud.data.data() + first * header_.step(), std::min(kPart, header_.points - first));
    }
  }

 private:
  [[noreturn]] void fail(const std::string& problem) const {
    throw FileError("cannot read " + path_.string() + ": " + problem +
                    "; it is no PCD file of a map or a damaged one");
  }

  /// The field with a name that is this one in lower case.
  std::optional<NumberField> find(const std::string& name) const {
    std::size_t offset = 0;
    for (const PcdField& field : header_.fields) {
      if (lower_case(field.name) == name && field.count == 1) {
        return NumberField{offset, field.size, field.type};
      }
      offset += field.size * field.count;
    }
    return std::nullopt;
  }

  void read_parts() {
    std::ifstream file(path_, std::ios::binary);
    file.seekg(static_cast<std::streamoff>(header_.text.size()));
    std::vector<std::uint8_t> bytes(std::min(kPart, header_.points) * header_.step());
    for (std::size_t first = 0; first < header_.points; first += kPart) {
      const std::size_t count = std::min(kPart, header_.points - first);
      file.read(reinterpret_cast<char*>(bytes.data()),
                static_cast<std::streamsize>(count * header_.step()));
      if (!file) fail("its end is missing");
      pass_on(bytes.data(), count);
    }
  }

  void pass_on(const std::uint8_t* bytes, std::size_t count) {
    points_.clear();
    for (std::size_t i = 0; i < count; ++i) add(bytes + i * header_.step());
    sink_(points_);
  }

  void add(const std::uint8_t* bytes) {
    MapPoint point;
    for (int axis = 0; axis < 3; ++axis) point.p_map[axis] = read_number(bytes, axes_[axis]);
    const double farthest = point.p_map.cwiseAbs().maxCoeff();
    if (!point.p_map.allFinite() || farthest > kMaxCoordinate) return;
    if (farthest > kMostOfFloats && axes_[0].size == 4) refuse_floats(farthest);
    if (intensity_) point.intensity = static_cast<float>(read_number(bytes, *intensity_));
    if (!std::isfinite(point.intensity)) point.intensity = 0.0F;
    points_.push_back(point);
  }

  [[noreturn]] void refuse_floats(double farthest) const {
    throw InputError(path_.string() + " has coordinates of " +
                     std::to_string(std::llround(farthest)) +
                     " m as floats of 4 bytes, which are more than a decimetre apart there; write "
                     "it with an offset subtracted, or with x y z of 8 bytes");
  }

  fs::path path_;
  const MapPointSink& sink_;
  PcdHeader header_;
  NumberField axes_[3];
  std::optional<NumberField> intensity_;
  std::vector<MapPoint> points_;
};

}  // namespace

void read_points(const fs::path& file, const MapPointSink& sink) { PointReader(file, sink).read(); }

}  // namespace lidar_mapping::map_import
