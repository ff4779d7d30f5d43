// SPDX-License-Identifier: BSD-3-Clause
#include "clouds/ouster_metadata.hpp"

#include <vector>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/units.hpp"

#include "json.hpp"

namespace lidar_mapping::ros_border {

namespace {

using json::Json;

constexpr double kMetresPerMillimetre = 1e-3;  // by definition

/// Newer firmware has groups of keys: the value of the key at the top, or in such a group. Null if
/// there is none.
const Json* find(const Json& metadata, const std::string& group, const std::string& key) {
  const auto at_top = metadata.find(key);
  if (at_top != metadata.end()) return &*at_top;
  const auto in_group = metadata.find(group);
  if (in_group == metadata.end() || !in_group->is_object()) return nullptr;
  const auto found = in_group->find(key);
  return found == in_group->end() ? nullptr : &*found;
}

const Json& at(const Json& metadata, const std::string& group, const std::string& key) {
  const Json* found = find(metadata, group, key);
  if (found == nullptr) throw InputError("they have no " + key);
  return *found;
}

double number(const Json& value, const std::string& key) {
  if (!value.is_number()) throw InputError(key + " has to be a number");
  return value.get<double>();
}

std::vector<double> numbers(const Json& value, const std::string& key) {
  if (!value.is_array()) throw InputError(key + " has to be a list of numbers");
  std::vector<double> numbers;
  for (const Json& element : value) numbers.push_back(number(element, key));
  return numbers;
}

std::vector<double> angles(const Json& metadata, const std::string& key) {
  std::vector<double> angles = numbers(at(metadata, "beam_intrinsics", key), key);
  for (double& angle : angles) angle *= kRadPerDeg;
  return angles;
}

std::size_t count(const Json& value, const std::string& key) {
  const double count = number(value, key);
  // By the format: numbers of columns have 16 bits.
  if (!(count >= 0.0 && count <= 65535.0)) throw InputError(key + " has to be from 0 to 65535");
  return static_cast<std::size_t>(count);
}

void set_columns(const Json& metadata, preprocessing::OusterFormat& format) {
  // The second name is that of newer firmware.
  const Json* data = find(metadata, "", "data_format");
  if (data == nullptr) data = &at(metadata, "", "lidar_data_format");
  const auto count_of = [&](const std::string& key) { return count(at(*data, "", key), key); };
  format.pixels_per_column = count_of("pixels_per_column");
  format.columns_per_packet = count_of("columns_per_packet");
  format.columns_per_frame = count_of("columns_per_frame");
  format.last_column = format.columns_per_frame - 1;
  if (const Json* window = find(*data, "", "column_window")) {
    const std::vector<double> ends = numbers(*window, "column_window");
    if (ends.size() != 2) throw InputError("column_window has to have two numbers");
    format.first_column = count(ends[0], "column_window");
    format.last_column = count(ends[1], "column_window");
  }
  // Older firmware has a single profile.
  const Json* profile = find(*data, "", "udp_profile_lidar");
  if (profile == nullptr) return;
  if (!profile->is_string()) throw InputError("udp_profile_lidar has to be a text");
  format.profile = preprocessing::ouster_profile(profile->get<std::string>());
}

void set_beams(const Json& metadata, preprocessing::OusterFormat& format) {
  const std::string group = "beam_intrinsics";
  format.altitudes = angles(metadata, "beam_altitude_angles");
  format.azimuths = angles(metadata, "beam_azimuth_angles");
  const std::string offset = "lidar_origin_to_beam_origin_mm";
  format.origin_to_beam = kMetresPerMillimetre * number(at(metadata, group, offset), offset);
  const std::string key = "beam_to_lidar_transform";
  const Json* transform = find(metadata, group, key);
  if (transform == nullptr) return;
  const std::vector<double> elements = numbers(*transform, key);
  if (elements.size() != 16) throw InputError(key + " has to have 16 numbers");
  format.origin_to_beam = kMetresPerMillimetre * elements[3];
  format.beam_height = kMetresPerMillimetre * elements[11];
}

}  // namespace

preprocessing::OusterFormat ouster_format(const std::string& metadata) try {
  const Json json = Json::parse(metadata);
  if (!json.is_object()) throw InputError("they are no JSON object");
  preprocessing::OusterFormat format;
  set_columns(json, format);
  set_beams(json, format);
  return format;
} catch (const Json::exception& error) {
  throw InputError(std::string("they are no JSON: ") + error.what());
}

}  // namespace lidar_mapping::ros_border
